"""Planar joints in the compiled loop."""
