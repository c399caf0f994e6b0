"""Spatial bodies whose frame turns, in the compiled loop."""
