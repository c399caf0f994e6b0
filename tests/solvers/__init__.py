"""Tests of the room `toolkit.solvers`."""
