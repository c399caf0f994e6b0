"""Bodies: what has mass and coordinates, and the markers through which all else sees them."""
