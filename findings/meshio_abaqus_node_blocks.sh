#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: A deck may give its nodes in several blocks. There are eight points; the first element is a
#   square of side 1 at z = 0, the second one of side 3 at z = 10.
# Seen: There are four points, those of the second block. Both elements lie on the same place at z = 10, the
#   first one three times too large. No error and no warning.
# Why: Decks that are put together of parts, and those that give reference points in a block of their own,
#   have several *NODE blocks. The elements before take coordinates of other nodes.
# Source: Abaqus Keywords Reference Guide, *NODE: the option may be repeated as often as needed. In
#   meshio/abaqus/_abaqus.py each *NODE block replaces points and numbers of the ones before.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import meshio

Path("two.inp").write_text("""*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
*ELEMENT, TYPE=CPS4
1, 1, 2, 3, 4
*NODE
11, 0, 0, 10
12, 3, 0, 10
13, 3, 3, 10
14, 0, 3, 10
*ELEMENT, TYPE=CPS4
2, 11, 12, 13, 14
""")
mesh = meshio.read("two.inp")
print("points:", len(mesh.points), "of 8")
for block in mesh.cells:
    print("element with corners at", mesh.points[block.data[0]].tolist())
first, second = (mesh.points[block.data[0]] for block in mesh.cells)
assert len(mesh.points) == 4
assert (first == second).all()
END
