"""Markers of spatial bodies in the compiled loop."""
