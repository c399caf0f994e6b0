"""A flexible body that is cut at nodes into parts, each with a floating frame of its own: what the plane and space share."""
