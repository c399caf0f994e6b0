"""Equilibria: one by Newton's iteration, or many along a path that is followed, never jumped."""
