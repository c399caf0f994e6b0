#!/usr/bin/env bash
# Version: meshio 5.3.5, files of gmsh in format MSH 4.1.
# Expected: gmsh names groups in every dimension by themselves: the curve with number 7 and the surface with
#   number 8 are both called skin. The set skin has one line and two triangles, or there are two sets.
# Seen: The name is kept with number 8 of the surface only. The set has the triangles and not the line, and
#   no name leads to number 7. No warning.
# Why: A side that is called like the part that it belongs to has no group any more, and a boundary
#   condition on it is not applied.
# Source: Reference manual of gmsh, description of MSH: a physical name stands with dimension and tag. In
#   meshio/gmsh/common.py the names are keys of one dictionary for all dimensions.
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
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
1 7 "skin"
2 8 "skin"
$EndPhysicalNames
$Entities
0 1 1 0
1 0 0 0 1 0 0 1 7 0
1 0 0 0 1 1 0 1 8 0
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
""")
mesh = meshio.read("plate.msh")
found = {block.type: len(part) for block, part in zip(mesh.cells, mesh.cell_sets["skin"])}
print("names:", {name: value.tolist() for name, value in mesh.field_data.items()}, "members of skin:", found)
assert found == {"line": 0, "triangle": 2}, found
assert len(mesh.field_data) == 1
END
