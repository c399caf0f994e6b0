"""Solids that are cut into pieces, of which each has two ends with positions and rotations, as a beam element has."""
