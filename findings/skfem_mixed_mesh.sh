#!/usr/bin/env bash
# Version: scikit-fem 12.0.2, meshio 5.3.5.
# Expected: The plate is a square of area 1 and a triangle of area 1 beside it. Meshes of scikit-fem have
#   one kind of element, so that such a file is refused.
# Seen: A MeshQuad1 with the square alone, area 1, and the free node of the triangle still in the list. The
#   kind that comes first is taken. No error and no warning.
# Why: Quadrilateral meshers leave some triangles, and brick meshers some wedges. The body has holes there,
#   and the free nodes make the equations singular, or not, by chance.
# Source: In skfem/io/meshio.py the loop over kinds ends at the first one that it knows; others of the same
#   dimension are not looked at.
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

Path("plate.vtk").write_text("""# vtk DataFile Version 3.0
plate
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 5 double
0 0 0
1 0 0
1 1 0
0 1 0
3 0 0
CELLS 2 9
4 0 1 2 3
3 1 4 2
CELL_TYPES 2
9
5
""")
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    mesh = skfem.Mesh.load("plate.vtk")
area = float(skfem.Basis(mesh, skfem.ElementQuad1()).dx.sum())
print(type(mesh).__name__, "with", mesh.t.shape[1], "element; area", area, "instead of 2; warnings:", len(said))
assert (mesh.t.shape[1], round(area, 12), len(said)) == (1, 1.0, 0)
END
