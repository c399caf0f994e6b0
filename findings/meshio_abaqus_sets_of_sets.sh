#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: ENDS is made of the sets LEFT and RIGHT, so that it has four nodes. BOTH is made of two sets and
#   has two elements.
# Seen: ENDS is there and has no node. BOTH has the members of the first named set only, one level of lists
#   deeper than other sets. No error and no warning.
# Why: A support that is named by the sets of its sides holds nothing, and a model that should be held moves
#   away, or the equations are singular in a place that nobody suspects.
# Source: Abaqus Keywords Reference Guide, *NSET and *ELSET: data lines hold numbers or names of sets that
#   were defined before. In meshio/abaqus/_abaqus.py names on data lines of *NSET are not used, and of a
#   line of names only the first.
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
    NODES
    + "*ELEMENT, TYPE=CPS4\n1, 1, 2, 3, 4\n2, 2, 5, 6, 3\n*NSET, NSET=LEFT\n1, 4\n*NSET, NSET=RIGHT\n7, 8\n*NSET, NSET=ENDS\nLEFT, RIGHT\n"
    + "*ELSET, ELSET=ONE\n1\n*ELSET, ELSET=TWO\n2\n*ELSET, ELSET=BOTH\nONE, TWO\n"
)
mesh = meshio.read("plate.inp")
ends = mesh.point_sets["ENDS"].tolist()
both = [part.tolist() for part in mesh.cell_sets["BOTH"][0]]
print("ENDS, of LEFT", mesh.point_sets["LEFT"].tolist(), "and RIGHT", mesh.point_sets["RIGHT"].tolist(), "has", ends)
print("BOTH, of the elements 0 and 1, has", both)
assert ends == []
assert both == [[0]]
END
