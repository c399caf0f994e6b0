#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: A card in free fields goes on in the next line, which begins with a comma: the first field is
#   blank. The brick has eight nodes, like the one whose second line begins with a plus sign.
# Seen: The second line is dropped, and meshio returns a block of kind hexahedron whose elements have six
#   nodes. No error and no warning.
# Why: What comes next takes six numbers for a brick: it writes a broken file, or reads past the end of the
#   row. All solid elements, and shells with mid-side nodes, have such second lines.
# Source: Quick reference guide of Nastran, format of bulk data entries: continuation marks may be left out
#   if the lines follow each other. In meshio/nastran/_nastran.py automatic continuation is found by eight
#   blanks, as in fixed fields.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import meshio

CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
GRID = "".join(f"GRID,{n},,{x}.,{y}.,{z}.\n" for n, (x, y, z) in enumerate(CORNERS, 1))
found = []
for mark in ("+", ""):
    Path("brick.bdf").write_text("BEGIN BULK\n" + GRID + "CHEXA,1,1,1,2,3,4,5,6\n" + mark + ",7,8\nENDDATA\n")
    block = meshio.read("brick.bdf").cells[0]
    found.append((block.type, block.data.shape[1]))
print("continuation with a plus sign:", found[0], "- with a blank first field:", found[1])
assert found == [("hexahedron", 8), ("hexahedron", 6)], found
END
