#!/usr/bin/env bash
# Version: meshio 5.3.5, files of gmsh in format MSH 4.1.
# Expected: Physical Curve(4) = {1, -2} has both curves, the second one in reversed orientation. gmsh writes
#   its tag as -4 with the entity. The group has two lines.
# Seen: The group edge has the line of the first curve only. The second curve has the number -4, which is
#   compared with 4. No warning.
# Why: Loops of curves are often collected with signs. Half of the boundary then has no name, so that a
#   support or a pressure acts on the other half only.
# Source: Reference manual of gmsh, section on physical groups: a minus sign reverses the orientation of the
#   elements. In meshio/gmsh/_gmsh41.py the number of the name is looked up in the list of signed tags.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import meshio

MESH = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
1
1 4 "edge"
$EndPhysicalNames
$Entities
0 2 1 0
1 0 0 0 1 0 0 1 4 0
2 1 0 0 1 1 0 1 SIGN4 0
1 0 0 0 1 1 0 1 9 0
$EndEntities
$Nodes
1 4 1 4
2 1 0 4
1
2
3
4
0 0 0
1 0 0
1 1 0
0 1 0
$EndNodes
$Elements
3 4 1 4
1 1 1 1
1 1 2
1 2 1 1
2 2 3
2 1 2 2
3 1 2 3
4 1 3 4
$EndElements
"""
lines = []
for sign in ("", "-"):
    Path("plate.msh").write_text(MESH.replace("SIGN", sign))
    mesh = meshio.read("plate.msh")
    lines.append(sum(len(part) for block, part in zip(mesh.cells, mesh.cell_sets["edge"]) if block.type == "line"))
print("lines of the group edge, both curves forwards:", lines[0], "- second curve backwards:", lines[1])
assert lines == [2, 1], lines
END
