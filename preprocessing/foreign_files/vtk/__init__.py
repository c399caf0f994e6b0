"""Meshes of VTK: the simple format .vtk and the one in XML, .vtu."""
