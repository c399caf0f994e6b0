#!/usr/bin/env bash
# Version: pyNastran 1.4.1, numpy 1.26.4.
# Expected: GRDSET gives the system in which points are that leave field 3 of GRID blank. GRID 1 leaves it
#   blank and lies at (11, 2, 3), like GRID 2, which names system 51.
# Seen: GRID 1 lies at (1, 2, 3), in the basic system, like GRID 3, which asks for that by 0. The default of
#   GRDSET for displacements, field 7, is applied, also to GRID 3, which has a blank there. No error and no
#   warning.
# Why: Decks that set a default once, to shift or to turn a part, come apart: points with and without the
#   number are in different systems.
# Source: Quick reference guide of Nastran, GRDSET: its entries are taken for blank fields 3, 7, 8 and 9 of
#   GRID. In pyNastran/bdf/cards/nodes.py cross_reference of GRID sets the reference of GRDSET and
#   overwrites it with the one of its own number, which has become 0 while reading.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pyNastran==1.4.1 numpy==1.26.4

venv/bin/python - <<'END'
from pathlib import Path
from pyNastran.bdf.bdf import BDF

Path("shifted.bdf").write_text("""GRDSET,,51,,,,51
CORD2R,51,,10.,0.,0.,10.,0.,1.
+,11.,0.,0.
GRID,1,,1.,2.,3.
GRID,2,51,1.,2.,3.
GRID,3,0,1.,2.,3.
""")
model = BDF(debug=None)
model.read_bdf("shifted.bdf", punch=True)
places = {number: node.get_position().tolist() for number, node in model.nodes.items()}
for number, how in {1: "blank, so 51 by GRDSET", 2: "51", 3: "0, the basic system"}.items():
    print(f"GRID {number}, system {how}: {places[number]}; displacements in {model.nodes[number].Cd()}")
assert places[2] == [11.0, 2.0, 3.0]
assert places[1] == places[3] == [1.0, 2.0, 3.0], places
END
