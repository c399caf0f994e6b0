"""Solvers: time integration, statics, frequencies, consistent starts, linear systems."""
