#!/usr/bin/env bash
# Version: meshio 5.3.5, h5py 3.16.0.
# Expected: A family of a MED file is a number that elements carry; it may be in any number of groups, also
#   in none, in which case the file has no table of groups (GRO) for it. The mesh is read, and the family
#   has no name.
# Seen: KeyError: object 'GRO' doesn't exist. The whole file cannot be read because of a family that has no
#   name.
# Why: gmsh writes a family for every part of the geometry, and those that are in no physical group have no
#   table of groups: a MED file of gmsh without named groups fails in meshio.
# Source: Documentation of MED files, chapter on families: the number of groups of a family may be zero. In
#   meshio/med/_med.py the reader of families asks for GRO in every one.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6 h5py==3.16.0

venv/bin/python - <<'END'
import h5py
import meshio
import numpy as np

points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], float)
mesh = meshio.Mesh(points, [("triangle", np.array([[0, 1, 2]]))], cell_data={"cell_tags": [np.array([-1])]})
mesh.cell_tags = {-1: ["plate"]}
meshio.write("one.med", mesh)
print("with a group:", meshio.read("one.med").cell_tags)
with h5py.File("one.med", "r+") as file:
    families = next(iter(file["FAS"].values()))["ELEME"]
    del next(iter(families.values()))["GRO"]
failure = None
try:
    meshio.read("one.med")
except KeyError as error:
    failure = str(error)
print("family without a group:", failure)
assert failure is not None and "GRO" in failure
END
