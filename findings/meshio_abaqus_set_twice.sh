#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: A name of a set that a deck uses again extends the set: FIXED has nodes 1, 4, 7 and 8, and ALL
#   has all three elements.
# Seen: FIXED has only nodes 7 and 8. ALL has one of the two quadrilaterals. A set over two kinds of
#   elements that meshio has written itself loses the first part when it is read. No warning.
# Why: Sets say where a body is held and what it is made of. Half of a support is missing, or half of the
#   elements have no material. Programs write a set in parts for every kind of element.
# Source: Abaqus Keywords Reference Guide, *NSET, *ELSET and the parameter ELSET of *ELEMENT: members are
#   added to a set of that name that exists. In meshio/abaqus/_abaqus.py the dictionaries of sets are
#   assigned anew at every occurrence.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import meshio
import numpy as np

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
    NODES
    + "*ELEMENT, TYPE=CPS4, ELSET=ALL\n1, 1, 2, 3, 4\n2, 2, 5, 6, 3\n*ELEMENT, TYPE=CPS3, ELSET=ALL\n3, 5, 7, 8\n"
    + "*NSET, NSET=FIXED\n1, 4\n*NSET, NSET=FIXED\n7, 8\n"
)
mesh = meshio.read("plate.inp")
fixed = sorted(int(node) + 1 for node in mesh.point_sets["FIXED"])
members = [len(part) for part in mesh.cell_sets["ALL"]]
print("nodes of FIXED:", fixed, "of 1, 4, 7, 8")
print("elements of ALL among", [len(block.data) for block in mesh.cells], "quadrilaterals and triangles:", members)

# A set over two kinds is written by meshio as one set in two parts, of which it then reads the last.
mesh.point_sets, mesh.cell_sets = {}, {"BOTH": [np.array([0, 1]), np.array([0])]}
meshio.write("again.inp", mesh)
again = [len(part) for part in meshio.read("again.inp").cell_sets["BOTH"]]
print("a set of 2 and 1 elements, written by meshio and read by meshio:", again)
assert (fixed, members, again) == ([7, 8], [1, 1], [0, 1]), (fixed, members, again)
END
