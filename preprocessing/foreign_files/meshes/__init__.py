"""Meshes of other formats, and what the readers of all of them share."""
