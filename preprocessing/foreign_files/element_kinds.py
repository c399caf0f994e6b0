"""Kinds of elements, in the words of meshio."""

from __future__ import annotations

PLANE = {"triangle": 3, "triangle6": 6, "quad": 4, "quad8": 8, "quad9": 9}
"""Kinds of elements that are used, and their numbers of nodes."""
SPATIAL = {"tetra": 4, "tetra10": 10, "hexahedron": 8, "hexahedron20": 20, "hexahedron27": 27, "wedge": 6, "wedge15": 15}
"""The same in space."""
LOWER = {"vertex": 1, "line": 2, "line3": 3}
"""Kinds that serve to name groups only; in space those of the plane too."""
SOLID = ("tetra", "hexahedron", "wedge", "pyramid")
"""Beginnings of the names of spatial kinds."""
KNOWN = {**LOWER, **PLANE, **SPATIAL}
"""All of which meshes may consist."""
