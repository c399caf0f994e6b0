"""Meshes as plain arrays: made by gmsh along a curve, or read from files of other programs."""
