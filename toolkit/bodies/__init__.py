"""Bodies: what has mass and coordinates."""
