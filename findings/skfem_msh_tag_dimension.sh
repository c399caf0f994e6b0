#!/usr/bin/env bash
# Version: scikit-fem 12.0.2, meshio 5.3.5, files of gmsh in format MSH 2.2.
# Expected: Numbers of physical groups are counted in every dimension by themselves: curve 1 is called wall
#   and surface 1 is called body. The part of both triangles is called body.
# Seen: The part is called wall, and there is no body. The name of the first group with the number is taken,
#   whatever its dimension is. No warning.
# Why: mesh.subdomains["body"] fails, or, with more parts, the material of one part goes to another one that
#   happens to have the number of a curve.
# Source: Reference manual of gmsh, description of MSH: a physical name stands with dimension and number. In
#   skfem/io/meshio.py the name is looked up by the number only.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check scikit-fem==12.0.2 scipy==1.17.1 meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import skfem

Path("plate.msh").write_text("""$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
1 1 "wall"
2 1 "body"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
$EndNodes
$Elements
3
1 1 2 1 1 1 2
2 2 2 1 1 1 2 3
3 2 2 1 1 1 3 4
$EndElements
""")
mesh = skfem.Mesh.load("plate.msh")
parts = {name: members.tolist() for name, members in mesh.subdomains.items()}
sides = {name: members.tolist() for name, members in mesh.boundaries.items()}
print("parts:", parts, "- sides:", sides)
assert parts == {"wall": [0, 1]}, parts
assert sides == {"wall": [0]}, sides
END
