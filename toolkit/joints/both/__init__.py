"""Joints whose rows are the same in the plane and in space, one kind per file for both."""
