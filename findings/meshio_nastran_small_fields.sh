#!/usr/bin/env bash
# Version: meshio 5.3.5, with point_format="fixed-small".
# Expected: A field of eight places holds 2.5e-6 and 1.4e-6 exactly (2.5-6, 1.4-6), and any number to four
#   figures or more.
# Seen: Numbers are written with six decimals and cut to eight places: 2.5e-6 becomes 0.000003 and 1.4e-6
#   becomes 0.000001, wrong by 20 and 30 percent. What is below 5e-7 becomes 0. No warning.
# Why: A mesh of a sensor or a chip in metres falls apart: nodes come to lie on each other, and elements
#   have no area.
# Source: User's guide of Nastran: real numbers may have an exponent, without the letter. In
#   meshio/nastran/_nastran.py small fields are formatted by a fixed number of decimals.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
import meshio
import numpy as np

points = np.array([(0, 0, 0), (2.5e-6, 0, 0), (0, 1.4e-6, 0)])
meshio.nastran.write("chip.bdf", meshio.Mesh(points, [("triangle", np.array([[0, 1, 2]]))]), point_format="fixed-small")
back = meshio.read("chip.bdf").points
print("written:", points[1, 0], points[2, 1], "- in the file:", back[1, 0], back[2, 1])
assert (back[1, 0], back[2, 1]) == (3e-6, 1e-6), back
END
