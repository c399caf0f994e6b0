"""Meshes as plain arrays, read from files of other programs, and input files."""
