"""Bodies: what has mass and coordinates, in the plane and in space; one kind per file."""
