#!/usr/bin/env bash
# Version: meshio 5.3.5, files of gmsh in format MSH 4.1.
# Expected: Where the curve is in a physical group and the surface is in none, the file is read, and the
#   surface has no number of a group.
# Seen: ValueError: Incompatible cell data 'gmsh:physical'. 2 cell blocks, but 'gmsh:physical' has 1 blocks.
#   The file is valid: gmsh writes such files with Mesh.SaveAll = 1.
# Why: It is common to name the sides of a body that carry supports and loads and nothing else, and to save
#   all. These files cannot be read, and the message looks like a broken file.
# Source: Reference manual of gmsh, option Mesh.SaveAll: elements are saved also where they belong to no
#   physical group. In meshio/gmsh/_gmsh41.py blocks without a number are left out of the list that has to
#   have an entry for each.
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
$Entities
0 1 1 0
1 0 0 0 1 0 0 1 7 0
1 0 0 0 1 1 0 GROUPS 0
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
2 3 1 3
1 1 1 1
1 1 2
2 1 2 2
2 1 2 3
3 1 3 4
$EndElements
"""
outcomes = []
for groups in ("1 8", "0"):
    Path("plate.msh").write_text(MESH.replace("GROUPS", groups))
    try:
        outcomes.append([block.type for block in meshio.read("plate.msh").cells])
    except ValueError as error:
        outcomes.append(str(error))
print("curve and surface in a group:", outcomes[0])
print("only the curve in a group:", outcomes[1])
assert outcomes[0] == ["line", "triangle"], outcomes
assert outcomes[1].startswith("Incompatible cell data 'gmsh:physical'"), outcomes
END
