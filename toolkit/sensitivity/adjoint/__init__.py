"""Gradients by the discrete adjoint: backwards through the steps of a run."""
