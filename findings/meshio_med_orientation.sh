#!/usr/bin/env bash
# Version: meshio 5.3.5, h5py 3.16.0.
# Expected: The base of a solid element of MED runs the other way round than that of meshio, VTK or gmsh. A
#   tetrahedron of Salome has a positive volume once it is read, and one that meshio writes is a valid one
#   of MED.
# Seen: Nodes are passed on as they are in both directions. The tetrahedron that is read has a volume of
#   -1/6. The one that meshio writes has a negative determinant when gmsh 4.15 reads it with the MED
#   library. No warning.
# Why: Elements with a negative Jacobian have a negative mass and stiffness, or the next program refuses the
#   mesh. Surfaces derived of it have normals that point inwards, so that a pressure pulls.
# Source: Reference elements in the documentation of MED; the tables of node numbers in the MED reader of
#   gmsh (GModelIO_MED) exchange the second and third node of a tetrahedron. In meshio/med/_med.py no order
#   is changed.
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

points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float)
meshio.write("one.med", meshio.Mesh(points, [("tetra", np.array([[0, 1, 2, 3]]))]))


def nodes_of_tetrahedra(file):
    """The array of nodes of tetrahedra, wherever in the file it stands."""
    found = []
    file.visititems(lambda name, item: found.append(item) if name.endswith("TE4/NOD") else None)
    return found[0]


def volume(mesh):
    a, b, c, d = mesh.points[mesh.cells[0].data[0]]
    return float(np.linalg.det([b - a, c - a, d - a]) / 6)


with h5py.File("one.med", "r+") as file:
    nodes = nodes_of_tetrahedra(file)
    written = nodes[()].tolist()
    nodes[...] = [1, 3, 2, 4]  # The same tetrahedron in the order of MED, as Salome and gmsh write it.
read = volume(meshio.read("one.med"))
print("nodes that meshio writes:", written, "instead of [1, 3, 2, 4]")
print("volume of the tetrahedron in the order of MED, read by meshio:", read, "instead of", 1 / 6)
assert written == [1, 2, 3, 4], written
assert abs(read + 1 / 6) < 1e-12, read
END
