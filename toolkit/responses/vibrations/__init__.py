"""Vibrations about an equilibrium as responses."""
