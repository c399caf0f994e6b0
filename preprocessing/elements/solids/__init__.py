"""Solid elements: shape functions, elasticity, matrices and stress."""
