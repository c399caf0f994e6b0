#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: A library function that cannot read a file raises an exception, meshio.ReadError. Here it is a
#   valid legacy VTK file with a voxel (kind 11) that meshio does not read.
# Seen: meshio.read prints a line and calls sys.exit(1). `except Exception` does not catch that, nor `except
#   meshio.ReadError`: the program that reads hundreds of files ends at this one.
# Why: A study or a service that reads meshes of users loses all that it was doing because of one file.
#   Voxels are what images and scans become in VTK.
# Source: The documentation of meshio names meshio.read as a function of the Python interface and ReadError
#   as its error. In meshio/_helpers.py the reader prints the ReadError and leaves by sys.exit.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import meshio

points = "".join(f"{x} {y} {z}\n" for z in (0, 1) for y in (0, 1) for x in (0, 1))
Path("voxel.vtk").write_text(
    "# vtk DataFile Version 3.0\nvoxel\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 double\n"
    + points + "CELLS 1 9\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 1\n11\n"
)
outcome = None
try:
    try:
        meshio.read("voxel.vtk")
    except Exception as error:
        outcome = f"an exception that a program can catch: {error!r}"
except SystemExit as end:
    outcome = f"SystemExit({end.code})"
print("reading a VTK file with a voxel:", outcome)
assert outcome == "SystemExit(1)", outcome
END
