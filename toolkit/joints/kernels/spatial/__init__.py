"""Spatial joints in the compiled loop, and the quadratic forms that they consist of."""
