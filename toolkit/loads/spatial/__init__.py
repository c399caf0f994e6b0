"""Loads in space."""
