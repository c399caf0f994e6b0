"""Names of the methods for gradients; the only list of them."""

EXACT = ("direct", "adjoint")
NUMERICAL = ("complex-step", "forward-difference", "central-difference")
METHODS = ("auto", *EXACT, *NUMERICAL)
