"""Joints in the compiled loop: what the rows of all kinds go through."""
