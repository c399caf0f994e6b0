#!/usr/bin/env bash
# Version: scikit-fem 12.0.2, meshio 5.3.5.
# Expected: A triangle with corners at different z is a surface in space of area 1.118. scikit-fem has plane
#   triangles only and refuses the file.
# Seen: z is cut off and a plane triangle of area 0.5 is returned. No error and no warning. A surface along
#   the z axis becomes a line of elements without area.
# Why: Meshes of shells and of surfaces of solids are files of triangles. What is computed is the shadow of
#   the body on the xy plane.
# Source: In skfem/mesh/mesh_2d.py all coordinates after the second are stripped, with the remark that
#   meshio appends z = 0; whether it is 0 is not checked.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check scikit-fem==12.0.2 scipy==1.17.1 meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import warnings
import skfem

Path("roof.vtk").write_text("""# vtk DataFile Version 3.0
roof
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 3 double
0 0 0
1 0 2
0 1 0
CELLS 1 4
3 0 1 2
CELL_TYPES 1
5
""")
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    mesh = skfem.Mesh.load("roof.vtk")
area = float(skfem.Basis(mesh, skfem.ElementTriP1()).dx.sum())
print("coordinates per node:", mesh.p.shape[0], "- area:", area, "instead of", 5**0.5 / 2, "- warnings:", len(said))
assert (mesh.p.shape[0], area, len(said)) == (2, 0.5, 0)
END
