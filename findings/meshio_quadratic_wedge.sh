#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: A wedge of 15 nodes is read from Abaqus (C3D15), VTK (kind 26) and gmsh (kind 18): the readers
#   have it in their tables of elements.
# Seen: All three files fail with KeyError: 'wedge15', and so does a mesh that is made in Python. Pyramids
#   of 13 nodes fail in the same way. The message names no file and no reason.
# Why: A swept quadratic mesh, the usual one of a shaft or a blade, cannot be read at all, although the list
#   of supported elements says that it can.
# Source: In meshio/_mesh.py the table of dimensions of elements has wedge18 and pyramid14, and neither
#   wedge15 nor pyramid13, which the tables of gmsh, VTK, Abaqus, Nastran, MED and others have.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import meshio
import numpy as np

corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)], float)
EDGES = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
points = np.vstack([corners, [(corners[a] + corners[b]) / 2 for a, b in EDGES]])
numbers = list(range(1, 16))

deck = "*NODE\n" + "".join(f"{n}, {x}, {y}, {z}\n" for n, (x, y, z) in zip(numbers, points))
Path("wedge.inp").write_text(deck + "*ELEMENT, TYPE=C3D15\n1, " + ", ".join(map(str, numbers)) + "\n")
vtk = "# vtk DataFile Version 3.0\nwedge\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 15 double\n"
vtk += "".join(f"{x} {y} {z}\n" for x, y, z in points) + "CELLS 1 16\n15 " + " ".join(str(n - 1) for n in numbers)
Path("wedge.vtk").write_text(vtk + "\nCELL_TYPES 1\n26\n")
gmsh_order = [1, 2, 3, 4, 5, 6, 7, 9, 13, 8, 14, 15, 10, 12, 11]
msh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n15\n" + "".join(f"{n} {x} {y} {z}\n" for n, (x, y, z) in zip(numbers, points))
msh += "$EndNodes\n$Elements\n1\n1 18 2 1 1 " + " ".join(map(str, gmsh_order)) + "\n$EndElements\n"
Path("wedge.msh").write_text(msh)

failures = {}
for name in ("wedge.inp", "wedge.vtk", "wedge.msh"):
    try:
        meshio.read(name)
    except KeyError as error:
        failures[name] = repr(error)
try:
    meshio.Mesh(points, [("wedge15", np.arange(15)[None])])
except KeyError as error:
    failures["meshio.Mesh"] = repr(error)
for name, failure in failures.items():
    print(name, "fails with", failure)
assert len(failures) == 4 and set(failures.values()) == {"KeyError('wedge15')"}, failures
END
