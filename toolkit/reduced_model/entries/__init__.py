"""Matrices of a reduced model by those of their entries that are not zero."""
