"""Matrices of a whole body on its nodal coordinates, and the contractions with a basis that make its invariants."""
