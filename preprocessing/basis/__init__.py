"""Reduction bases and their derivatives: boundary, constraint modes, normal modes."""
