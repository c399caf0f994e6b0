#!/usr/bin/env bash
# Version: meshio 5.3.5, legacy VTK files.
# Expected: A file with two elements says that one is of material 7 and one of material 8. It does so too
#   where the first is a polygon of four corners (kind 7) in place of a quadrilateral (kind 9).
# Seen: With one polygon anywhere in the file all cell data are gone, also those of the other elements. No
#   error and no warning.
# Why: Materials and groups of a mesh are cell data. The mesh looks complete, and all of it becomes one
#   material.
# Source: Description of the legacy VTK format: CELL_DATA go with cells of any kind. In
#   meshio/vtk/_vtk_42.py the branch for files with polygons notes that cell data are still to be done.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import meshio

HEAD = "# vtk DataFile Version 3.0\nplate\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0.5 0\n"
names = []
for kind in (9, 7):
    cells = f"CELLS 2 9\n4 0 1 2 3\n3 1 4 2\nCELL_TYPES 2\n{kind}\n5\n"
    Path("plate.vtk").write_text(HEAD + cells + "CELL_DATA 2\nSCALARS material int 1\nLOOKUP_TABLE default\n7\n8\n")
    mesh = meshio.read("plate.vtk")
    names.append(sorted(mesh.cell_data))
    print([block.type for block in mesh.cells], "cell data:", names[-1])
assert names == [["material"], []], names
END
