#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: The assembly has two instances of a part, moved by 5 and by 6 along x: two squares between x = 5
#   and x = 7. A reader that knows no assemblies refuses the deck.
# Seen: One square between x = 0 and x = 1. Neither the second instance nor the movement is there, and no
#   error or warning says so.
# Why: Decks of Abaqus/CAE are written in parts and instances unless that is switched off. All parts come to
#   lie on top of each other at the origin, and those that occur several times occur once.
# Source: Abaqus Keywords Reference Guide, *INSTANCE: the first data line is a translation, the second a
#   rotation. In meshio/abaqus/_abaqus.py *INSTANCE is one of the keywords that are skipped with their data
#   lines.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import meshio

Path("two.inp").write_text("""*HEADING
*PART, NAME=TILE
*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
*ELEMENT, TYPE=CPS4
1, 1, 2, 3, 4
*END PART
*ASSEMBLY, NAME=FLOOR
*INSTANCE, NAME=TILE-1, PART=TILE
5, 0, 0
*END INSTANCE
*INSTANCE, NAME=TILE-2, PART=TILE
6, 0, 0
*END INSTANCE
*END ASSEMBLY
""")
mesh = meshio.read("two.inp")
elements, x = sum(len(block.data) for block in mesh.cells), mesh.points[:, 0]
print("elements:", elements, "of 2, from x =", x.min(), "to", x.max(), "instead of from 5 to 7")
assert (elements, x.min(), x.max()) == (1, 0.0, 1.0)
END
