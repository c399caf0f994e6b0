#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: Nastran makes no difference between upper and lower case. The triangle with its three nodes is
#   read in both spellings.
# Seen: In lower case, after BEGIN BULK in upper case, the mesh has no node and no element, and there is no
#   error and no warning. Where only some cards are in lower case, these are missing.
# Why: A preprocessor of one's own, or an editor, may write lower case. A mesh without elements passes for a
#   result, and one that lacks some of them even more.
# Source: User's guide of Nastran, format of bulk data: entries may be in upper or lower case. In
#   meshio/nastran/_nastran.py the names of cards are compared as they stand, and others are skipped.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import meshio

CARDS = "grid,1,,0.,0.,0.\ngrid,2,,1.,0.,0.\ngrid,3,,0.,1.,0.\nctria3,1,1,1,2,3\n"
found = []
for cards in (CARDS.upper(), CARDS):
    Path("triangle.bdf").write_text("BEGIN BULK\n" + cards + "ENDDATA\n")
    mesh = meshio.read("triangle.bdf")
    found.append((len(mesh.points), sum(len(block.data) for block in mesh.cells)))
print("nodes and elements in upper case:", found[0], "- in lower case:", found[1])
assert found == [(3, 1), (0, 0)], found
END
