"""Analyses of a compiled scene: a motion, an equilibrium, modes; each with its verdict."""
