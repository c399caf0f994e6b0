"""Loads in the compiled loop: what the forces of all kinds go through."""
