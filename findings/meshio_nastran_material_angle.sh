#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: The field after the nodes of CQUAD4 and CTRIA3 is the angle of the material, a real number, or
#   the number of a system that it follows. The mesh is read without it.
# Seen: An angle fails with ValueError: invalid literal for int(), the number of a system with
#   AssertionError: Illegal cell type quad. The field is taken for one more node.
# Why: Every composite shell has this field, and preprocessors may write 0.0 in it for others. Such files
#   cannot be read, and the message names neither the card nor the line.
# Source: Quick reference guide of Nastran, CQUAD4 and CTRIA3: THETA or MCID follows the nodes. In
#   meshio/nastran/_nastran.py all fields from the fourth on are nodes.
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
failures = []
for card in ("CQUAD4,1,1,1,2,3,4,45.0", "CQUAD4,1,1,1,2,3,4,5", "CTRIA3,1,1,1,2,3,45.0"):
    Path("shell.bdf").write_text("BEGIN BULK\n" + GRID + card + "\nENDDATA\n")
    try:
        meshio.read("shell.bdf")
    except (AssertionError, ValueError) as error:
        failures.append(type(error).__name__)
        print(f"{card}: {error!r}")
assert failures == ["ValueError", "AssertionError", "ValueError"], failures
END
