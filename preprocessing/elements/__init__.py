"""Finite elements of beams, and the sections that they are made of."""
