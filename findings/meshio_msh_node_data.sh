#!/usr/bin/env bash
# Version: meshio 5.3.5, files of gmsh in ASCII formats MSH 2.2 and 4.1.
# Expected: Every line of $NodeData says which node its value belongs to. Node 1 has 10, node 4 has 40, in
#   whatever order the lines come.
# Seen: Values are taken in the order of the lines: node 1 has 40 and node 4 has 10. The numbers of the
#   nodes are not looked at. No warning.
# Why: Temperatures, loads and displacements of a file act at other nodes than it says. Binary files of
#   another order are refused by meshio, so the danger is known there.
# Source: Reference manual of gmsh, description of MSH: lines of $NodeData begin with the tag of the node.
#   In meshio/gmsh/common.py the first column of ASCII data is cut off. $ElementData goes the same way.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import meshio

Path("plate.msh").write_text("""$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
4
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
$EndNodes
$Elements
2
1 2 2 1 1 1 2 3
2 2 2 1 1 1 3 4
$EndElements
$NodeData
1
"temperature"
1
0.0
3
0
1
4
4 40
3 30
2 20
1 10
$EndNodeData
""")
values = meshio.read("plate.msh").point_data["temperature"].tolist()
print("values at nodes 1, 2, 3, 4:", values, "where the file says 10, 20, 30, 40")
assert values == [40.0, 30.0, 20.0, 10.0], values
END
