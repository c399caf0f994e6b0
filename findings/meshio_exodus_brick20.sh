#!/usr/bin/env bash
# Version: meshio 5.3.5, netCDF4 1.7.4.
# Expected: A brick of 20 nodes with straight edges, read from Exodus and written to VTK, has each node in
#   the middle of the edge where VTK has it. Exodus has nodes of the upright edges before those of the top,
#   VTK after.
# Seen: The eight nodes of upright and top edges are exchanged: node 12 of VTK, which belongs on an edge of
#   the top, lies on an upright edge. No warning.
# Why: The quadratic brick of Cubit and of the Sierra and MOOSE programs becomes an element whose edges run
#   across it. Its volume and its mass are wrong and the mapping folds.
# Source: Figure of HEX elements in the report EXODUS II: A Finite Element Data Model, and the documentation
#   of vtkQuadraticHexahedron. In meshio/exodus/_exodus.py nodes of elements are passed on in the order of
#   the file.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6 netCDF4==1.7.4

venv/bin/python - <<'END'
import meshio
import netCDF4
import numpy as np

corners = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)], float)
BOTTOM, UP, TOP = [(0, 1), (1, 2), (2, 3), (3, 0)], [(0, 4), (1, 5), (2, 6), (3, 7)], [(4, 5), (5, 6), (6, 7), (7, 4)]
points = np.vstack([corners, [(corners[a] + corners[b]) / 2 for a, b in BOTTOM + UP + TOP]])
with netCDF4.Dataset("brick.e", "w", format="NETCDF3_64BIT_OFFSET") as file:
    file.title, file.api_version, file.version = "brick", np.float32(5.1), np.float32(5.1)
    file.floating_point_word_size, file.file_size = np.int32(8), np.int32(1)
    sizes = {"len_string": 33, "len_name": 33, "num_dim": 3, "num_nodes": 20, "num_elem": 1, "num_el_blk": 1}
    for name, size in {**sizes, "num_el_in_blk1": 1, "num_nod_per_el1": 20, "time_step": None}.items():
        file.createDimension(name, size)
    file.createVariable("time_whole", "f8", ("time_step",))
    for k, axis in enumerate("xyz"):
        file.createVariable(f"coord{axis}", "f8", ("num_nodes",))[:] = points[:, k]
    file.createVariable("eb_status", "i4", ("num_el_blk",))[:] = 1
    numbers = file.createVariable("eb_prop1", "i4", ("num_el_blk",))
    numbers.setncattr("name", "ID")
    numbers[:] = 1
    connect = file.createVariable("connect1", "i4", ("num_el_in_blk1", "num_nod_per_el1"))
    connect.elem_type = "HEX20"
    connect[:] = np.arange(1, 21)[None]

mesh = meshio.read("brick.e")
meshio.write("brick.vtk", mesh)
mesh = meshio.read("brick.vtk")
nodes = mesh.points[mesh.cells[0].data[0]]
away = [8 + k for k, (a, b) in enumerate(BOTTOM + TOP + UP) if not np.allclose(nodes[8 + k], (nodes[a] + nodes[b]) / 2)]
print("kind:", mesh.cells[0].type, "- nodes that are not in the middle of their edge in VTK:", away)
assert away == [12, 13, 14, 15, 16, 17, 18, 19], away
END
