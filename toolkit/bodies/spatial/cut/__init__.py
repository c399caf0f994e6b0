"""A flexible body in space that is cut at nodes into parts, each with a floating frame of its own."""
