#!/usr/bin/env bash
# Version: scikit-fem 12.0.2, meshio 5.3.5.
# Expected: skfem.Mesh.load reads a VTK file with one wedge as a MeshWedge1, as its table of kinds says.
# Seen: KeyError: 'wedge', for any file with wedges, and without a word of what is wrong.
# Why: A swept mesh of wedges cannot be loaded from any file, although the class for it is there.
# Source: In skfem/io/meshio.py the table of meshes has wedges, and the table of boundaries, which is asked
#   next, has none.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check scikit-fem==12.0.2 scipy==1.17.1 meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import skfem
from skfem.io.meshio import MESH_TYPE_MAPPING

Path("wedge.vtk").write_text("""# vtk DataFile Version 3.0
wedge
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 6 double
0 0 0
0 1 0
1 0 0
0 0 1
0 1 1
1 0 1
CELLS 1 7
6 0 1 2 3 4 5
CELL_TYPES 1
13
""")
failure = None
try:
    skfem.Mesh.load("wedge.vtk")
except KeyError as error:
    failure = repr(error)
print("wedges are to become", MESH_TYPE_MAPPING["wedge"].__name__, "- loading fails with", failure)
assert failure == "KeyError('wedge')", failure
END
