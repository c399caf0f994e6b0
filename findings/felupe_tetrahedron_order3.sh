#!/usr/bin/env bash
# Version: FElupe 11.3.0.
# Expected: The rule of order 3 for a tetrahedron integrates polynomials up to degree 3 exactly, and at
#   least x, y and z, whose integrals are 1/24 each.
# Seen: The integrals are 1.6, 1.6 and 0.4 times 1/24. The fourth point is (1/2, 1/2, 1/6), outside of the
#   tetrahedron, where (1/6, 1/6, 1/2) is missing. No error and no warning.
# Why: Body forces, centres of mass and mass matrices that are integrated by this rule are lopsided: they
#   depend on which corner of the element is numbered first.
# Source: The rule of five points, one at the centre and four that are the same by symmetry, as in the book
#   of Zienkiewicz, Taylor and Zhu that the documentation cites. In felupe/quadrature/_tetra.py the last of
#   the four points has one coordinate in the place of another.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check felupe==11.3.0 numpy==2.4.6

venv/bin/python - <<'END'
import felupe
import numpy as np

found = {}
for order in (1, 2, 3):
    scheme = felupe.TetrahedronQuadrature(order=order)
    moments = scheme.weights @ scheme.points * 24
    found[order] = moments
    print(f"order {order}: integrals of x, y, z over those of the tetrahedron (1/24): {moments.round(6)}")
print("points of order 3:\n", felupe.TetrahedronQuadrature(order=3).points)
assert np.allclose(found[1], 1) and np.allclose(found[2], 1)
assert np.allclose(found[3], [1.6, 1.6, 0.4]), found[3]
END
