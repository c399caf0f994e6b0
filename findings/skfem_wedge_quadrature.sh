#!/usr/bin/env bash
# Version: scikit-fem 12.0.2.
# Expected: The volume of MeshWedge1(), a unit cube of two wedges, is 1, and the integral of x over it is
#   1/2. A rule of order 4 is exact for these.
# Seen: The volume is 0.5 and the integral of x is 0.2917. The weights add up to 1/4 where the wedge has a
#   volume of 1/2. The weights of the triangle are multiplied with themselves, first coordinates of its
#   points are paired with second coordinates of all others, and the rule of the line goes to x, although
#   the upright edges of the reference wedge are along z: many points have x + y > 1 and lie outside.
# Why: Masses, volumes and stiffnesses of a mesh of wedges are wrong by a factor, and not by the same one
#   everywhere, so that no scaling mends it. Each point also is evaluated many times.
# Source: Documentation of get_quadrature: the rule is accurate up to the requested order. In
#   skfem/quadrature.py the case of RefWedge makes a product of three one-dimensional sets of the line and
#   of both coordinates of the triangle.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check scikit-fem==12.0.2 scipy==1.17.1 numpy==2.4.6

venv/bin/python - <<'END'
from skfem import Basis, ElementWedge1, Functional, MeshWedge1
from skfem.quadrature import get_quadrature
from skfem.refdom import RefWedge

points, weights = get_quadrature(RefWedge, 4)
print("sum of weights of a wedge of volume 1/2:", weights.sum())
outside = int((points[0] + points[1] > 1).sum())
print("points:", weights.size, "of them outside, with x + y > 1:", outside)

mesh = MeshWedge1()
basis = Basis(mesh, ElementWedge1(), intorder=4)
print("a cube of two wedges between", mesh.p.min(axis=1), "and", mesh.p.max(axis=1))
found = {
    "1": float(basis.dx.sum()),
    "x": float(Functional(lambda w: w.x[0]).assemble(basis)),
    "x * y": float(Functional(lambda w: w.x[0] * w.x[1]).assemble(basis)),
}
for name, exact in {"1": 1.0, "x": 1 / 2, "x * y": 1 / 4}.items():
    print(f"integral of {name}: {found[name]:.6f} instead of {exact}")
assert outside > 0
assert abs(weights.sum() - 0.25) < 1e-12
assert abs(found["1"] - 0.5) < 1e-12
assert abs(found["x"] - 0.5) > 0.1
assert abs(found["x * y"] - 0.25) > 0.05
END
