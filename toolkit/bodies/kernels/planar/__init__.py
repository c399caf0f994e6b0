"""Planar bodies whose frame moves, in the compiled loop."""
