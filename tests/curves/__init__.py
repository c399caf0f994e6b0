"""Time curves."""
