"""Numbers that are not known exactly: their distributions, how they go together, and polynomials that are orthonormal for them."""
