#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: GRID 3 is given in the cylindrical system 7 at radius 2 and 90 degrees: it lies at (0, 2, 0),
#   and the triangle has an area of 2. A reader that knows no systems refuses the file.
# Seen: Radius and angle are taken as x and y: node 3 lies at (2, 90, 0), the area is 90. The numbers of
#   systems come as an array that is shorter than the number of nodes, because blanks are left out, so that
#   they belong to other nodes. No warning.
# Why: Rotors, shafts and tanks are described in cylindrical systems. The mesh that is read has another
#   shape, and nothing but a picture shows it.
# Source: Quick reference guide of Nastran, GRID: field 3 is the coordinate system in which the point is
#   given, by CORD2C in radius and degrees. In meshio/nastran/_nastran.py no card of a coordinate system is
#   read.
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

Path("sector.bdf").write_text("""BEGIN BULK
CORD2C,7,,0.,0.,0.,0.,0.,1.
+,1.,0.,0.
GRID,1,,0.,0.,0.
GRID,2,7,2.,0.,0.
GRID,3,7,2.,90.,0.
CTRIA3,1,1,1,2,3
ENDDATA
""")
mesh = meshio.read("sector.bdf")
a, b, c = mesh.points[mesh.cells[0].data[0]]
area = float(np.linalg.norm(np.cross(b - a, c - a)) / 2)
systems = mesh.point_data["nastran:ref"].tolist()
print("node 3 at", c.tolist(), "instead of [0, 2, 0]; area", area, "instead of 2")
print("systems of", len(mesh.points), "nodes:", systems)
assert c.tolist() == [2.0, 90.0, 0.0]
assert area == 90.0
assert systems == [7, 7]
END
