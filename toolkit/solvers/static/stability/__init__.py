"""Stability of an equilibrium, and how far it is from losing its stability."""
