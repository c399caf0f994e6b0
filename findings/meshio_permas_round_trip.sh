#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: A quadratic triangle that meshio writes to a PERMAS file and reads again has the same nodes in
#   the same places.
# Seen: The node in the middle of the first edge comes back as the second corner: [0, 3, 1, 4, 2, 5]. The
#   three corners lie on two edges. No warning. Tetrahedra of 10 and wedges of 15 nodes are reordered when
#   written and not when read too.
# Why: Files of PERMAS with quadratic elements become meshes of folded triangles, and the order that PERMAS
#   has is known to the same module.
# Source: In meshio/permas/_permas.py the writer has tables of the order of nodes for quadratic elements,
#   and the reader uses none of them.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
import meshio
import numpy as np

points = np.array([(0, 0, 0), (2, 0, 0), (0, 2, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
meshio.write("triangle.dato", meshio.Mesh(points, [("triangle6", np.arange(6)[None])]))
mesh = meshio.read("triangle.dato")
nodes = mesh.cells[0].data[0].tolist()
corners = mesh.points[nodes[:3], :2].tolist()
print("written [0, 1, 2, 3, 4, 5], read:", nodes, "- corners:", corners)
assert nodes == [0, 3, 1, 4, 2, 5], nodes
END
