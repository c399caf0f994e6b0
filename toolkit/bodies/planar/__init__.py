"""Bodies in the plane, as a scene describes them."""
