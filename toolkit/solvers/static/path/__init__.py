"""Paths of equilibria: steps along them, and the limit points on them."""
