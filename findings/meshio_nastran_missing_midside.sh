#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: Mid-side nodes of CQUAD8 may be left out by a blank field. The element has its nodes 7 and 8 in
#   places 7 and 8, and nothing in place 6, or the reader refuses it.
# Seen: The blank is removed and what follows moves up: kind quad8 with seven numbers, node 7 in place 6 and
#   node 8 in place 7. No error and no warning. CTETRA and CHEXA with a blank go the same way.
# Why: Elements with a side without a middle node join quadratic and linear parts of a mesh. The sides of
#   the element are curved to nodes of other sides, and the array has too few columns for its kind.
# Source: Quick reference guide of Nastran, CQUAD8: the nodes G5 to G8 are optional, any or all of them may
#   be deleted. In meshio/nastran/_nastran.py empty fields are removed from the list of nodes.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import meshio

POINTS = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
grid = "".join(f"GRID,{n},,{x}.,{y}.,0.\n" for n, (x, y) in enumerate(POINTS, 1))
# The shell has no node between corners 2 and 3: field G6 is blank.
Path("shell.bdf").write_text("BEGIN BULK\n" + grid + "CQUAD8,1,1,1,2,3,4,5,,+\n+,7,8\nENDDATA\n")
mesh = meshio.read("shell.bdf")
block = mesh.cells[0]
nodes = (block.data[0] + 1).tolist()
print("kind:", block.type, "- nodes:", nodes, "where node 7 should be in place 7 and node 8 in place 8")
assert (block.type, nodes) == ("quad8", [1, 2, 3, 4, 5, 7, 8]), nodes
END
