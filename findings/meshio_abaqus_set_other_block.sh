#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: The set TIP is the ELSET of the second *ELEMENT line, so that it has both triangles and no
#   quadrilateral.
# Seen: TIP has both quadrilaterals and no triangle, because the *ELEMENT line before has no ELSET. No error
#   and no warning.
# Why: The material or the load of one part goes to another one. Where the first block is the shorter one,
#   the set even has places that are no elements of it.
# Source: In meshio/abaqus/_abaqus.py the sets of *ELEMENT lines are counted among the lines that have one,
#   and this count is then used as the place among all blocks.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import meshio

NODES = """*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 2, 0, 0
6, 2, 1, 0
7, 3, 0, 0
8, 3, 1, 0
"""
Path("plate.inp").write_text(
    NODES + "*ELEMENT, TYPE=CPS4\n1, 1, 2, 3, 4\n2, 2, 5, 6, 3\n*ELEMENT, TYPE=CPS3, ELSET=TIP\n3, 5, 7, 8\n4, 5, 8, 6\n"
)
mesh = meshio.read("plate.inp")
found = {block.type: part.tolist() for block, part in zip(mesh.cells, mesh.cell_sets["TIP"])}
print("members of TIP:", found)
assert found == {"quad": [0, 1], "triangle": []}, found
END
