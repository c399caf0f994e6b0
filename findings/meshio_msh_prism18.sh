#!/usr/bin/env bash
# Version: meshio 5.3.5.
# Expected: A prism of 18 nodes with straight edges, read from gmsh and written to VTK, has each node on the
#   edge or the side where VTK has it. meshio reorders the prism of 15 nodes and bricks for that.
# Seen: Ten of the twelve nodes of edges and sides are in the place of others: node 7, in the middle between
#   the corners 1 and 2, lies between 0 and 2. No warning. Pyramids of 14 nodes are passed on unchanged too.
# Why: The 18-node prism is what gmsh makes of swept prisms at second order. In VTK, ParaView and any
#   program that reads meshio's meshes the elements are turned inside out.
# Source: Node ordering in the reference manual of gmsh, and the documentation of
#   vtkBiQuadraticQuadraticWedge. In meshio/gmsh/common.py the table of orders has 15-node prisms and
#   13-node pyramids and not the ones with nodes on sides.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import meshio
import numpy as np

corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)], float)
# Between which corners gmsh puts the nodes 7 to 18, and VTK (and meshio) those of its biquadratic wedge.
SIDES = [(0, 1, 4, 3), (0, 2, 5, 3), (1, 2, 5, 4)]
GMSH = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 4), (2, 5), (3, 4), (3, 5), (4, 5), *SIDES]
VTK = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5), SIDES[0], SIDES[2], SIDES[1]]
points = np.vstack([corners, [corners[list(among)].mean(axis=0) for among in GMSH]])
text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n18\n" + "".join(f"{n} {x} {y} {z}\n" for n, (x, y, z) in enumerate(points, 1))
text += "$EndNodes\n$Elements\n1\n1 13 2 1 1 " + " ".join(str(n) for n in range(1, 19)) + "\n$EndElements\n"
Path("prism.msh").write_text(text)

meshio.write("prism.vtk", meshio.read("prism.msh"))
mesh = meshio.read("prism.vtk")
nodes = mesh.points[mesh.cells[0].data[0]]
away = [6 + k for k, among in enumerate(VTK) if not np.allclose(nodes[6 + k], nodes[list(among)].mean(axis=0))]
print("kind:", mesh.cells[0].type, "- nodes that are not between their corners:", away)
assert mesh.cells[0].type == "wedge18"
assert away == [7, 8, 9, 10, 11, 12, 13, 14, 16, 17], away
END
