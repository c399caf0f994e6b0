"""Meshes of gmsh, .msh, of the versions 1, 2 and 4.1."""
