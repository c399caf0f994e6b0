#!/usr/bin/env bash
# Version: pyNastran 1.4.1, numpy 1.26.4.
# Expected: A brick of base 1 and height 1 whose top is shifted by 1 has a volume of 1, as shearing changes
#   none. A wedge of base 1/2 with upright edges 2, 1 and 1 has a volume of 2/3.
# Seen: The brick has a volume of 1.414 and the wedge one of 0.911, 37 percent too much, and mass_properties
#   sums them up. No warning.
# Why: Mass, centre of mass and inertia of a solid mesh are given too large wherever elements lean or taper,
#   and the numbers look reasonable. A regular mesh, which one would test with, is right.
# Source: The volume of a parallelepiped is a determinant. In pyNastran/bdf/cards/elements/solid.py the
#   volume of CHEXA and CPENTA is the mean of the areas of both ends times the distance of their centres,
#   which is no height unless the distance is at right angles to the ends.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pyNastran==1.4.1 numpy==1.26.4

venv/bin/python - <<'END'
from pathlib import Path
import numpy as np
from pyNastran.bdf.bdf import BDF
from pyNastran.bdf.mesh_utils.mass_properties import mass_properties

CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (1, 0, 1), (2, 0, 1), (2, 1, 1), (1, 1, 1)]
SIX = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 2), (1, 0, 1), (0, 1, 1)]
text = "".join(f"GRID,{n},,{x}.,{y}.,{z}.\n" for n, (x, y, z) in enumerate(CORNERS, 1))
text += "".join(f"GRID,{n},,{x}.,{y}.,{z}.\n" for n, (x, y, z) in enumerate(SIX, 11))
text += "MAT1,1,1000.,,.3,2.0\nPSOLID,1,1\n"
Path("solid.bdf").write_text(text + "CHEXA,1,1,1,2,3,4,5,6\n+,7,8\nCPENTA,2,1,11,12,13,14,15,16\n")
model = BDF(debug=None)
model.read_bdf("solid.bdf", punch=True)
brick, wedge = model.elements[1].Volume(), model.elements[2].Volume()
mass = mass_properties(model)[0]
print("brick of base 1 and height 1, sheared by 1:", brick, "instead of 1")
print("wedge of base 1/2 and upright edges 2, 1, 1:", wedge, "instead of", 0.5 * 4 / 3)
print("mass of both at density 2:", mass, "instead of", 2 * (1 + 2 / 3))
assert np.isclose(brick, 2**0.5)
assert np.isclose(wedge, 0.9106836)
assert np.isclose(mass, 2 * (brick + wedge))
END
