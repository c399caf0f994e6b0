"""Joints in the plane, one kind per file."""
