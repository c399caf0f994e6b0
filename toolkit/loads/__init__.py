"""Loads: forces between two markers, and the time curves that scale them."""
