#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: A line that begins with ** is a comment of an Abaqus deck and may stand anywhere, also between
#   the lines of *ELEMENT. The mesh has three elements with it or without.
# Seen: With the comment the mesh has one element. The other two are gone, without an error or a warning.
#   Rows of *NODE and of sets are lost in the same way.
# Why: Decks carry comments that were put in by hand or by a program for every part. The mesh that is read
#   has holes, or is a stump, and its mass and stiffness are too small.
# Source: Abaqus Analysis User's Guide, section on the syntax of input files: comment lines begin with two
#   asterisks and are ignored. In meshio/abaqus/_abaqus.py the loops over nodes, elements and sets end at
#   any line that begins with an asterisk.
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
ROWS = ["1, 1, 2, 3, 4\n", "2, 2, 5, 6, 3\n", "3, 5, 7, 8, 6\n"]
counts = []
for comment in ("", "** the other half\n"):
    Path("plate.inp").write_text(NODES + "*ELEMENT, TYPE=CPS4\n" + ROWS[0] + comment + ROWS[1] + ROWS[2])
    counts.append(sum(len(block.data) for block in meshio.read("plate.inp").cells))
print("elements without and with a comment line after the first of three:", counts)
assert counts == [3, 1], counts
END
