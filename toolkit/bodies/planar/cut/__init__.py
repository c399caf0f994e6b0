"""A flexible body in the plane that is cut at nodes into parts, each with a floating frame of its own."""
