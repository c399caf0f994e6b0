#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: Elements of a plane mesh are written as plane stress elements or shells (CPS4, S4, CPS3, S3), or
#   meshio asks which ones.
# Seen: Quadrilaterals are written as CAX4P, axisymmetric with pore pressure, triangles as R3D3, rigid
#   facets, lines as B31H, hybrid beams. No warning.
# Why: The written deck runs in Abaqus or fails there for reasons that have nothing to do with the mesh: the
#   plate has become a body of revolution that is full of water, next to a part that cannot deform.
# Source: Abaqus Elements Guide: CAX4P is an axisymmetric element for coupled pore pressure, R3D3 a rigid
#   one. In meshio/abaqus/_abaqus.py the table for writing is the reversed table for reading, in which the
#   last of all names with the same shape wins.
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

points = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0)], float)
cells = [("quad", np.array([[0, 1, 2, 3]])), ("triangle", np.array([[1, 4, 2]])), ("line", np.array([[0, 1]]))]
meshio.write("plate.inp", meshio.Mesh(points, cells))
kinds = [line.split("TYPE=")[1] for line in Path("plate.inp").read_text().splitlines() if line.startswith("*ELEMENT")]
print("quadrilateral, triangle and line are written as", kinds)
assert kinds == ["CAX4P", "R3D3", "B31H"], kinds
END
