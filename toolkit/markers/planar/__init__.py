"""Markers of planar bodies in the compiled loop."""
