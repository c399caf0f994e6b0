#!/usr/bin/env bash
# Version: SfePy 2026.3.
# Expected: The reference wedge of SfePy (geometry 3_6) is a triangle times a line and has a volume of 1/2,
#   whatever the order of integration is.
# Seen: Orders 1 to 3 give 0.5. From order 4 on the rule is the one of the cube: the volume is 1, and points
#   with x + y > 1 lie outside of the wedge. No error and no warning.
# Why: Volumes, masses and stiffnesses of a mesh of wedges are about twice too large as soon as somebody
#   asks for a better integration, and it is asked for by a number only.
# Source: The note at the top of the module of quadratures says that products are for quadrilaterals and
#   bricks. In sfepy/discrete/quadratures.py every geometry that is no simplex gets a product of line rules
#   when the order is above that of its table, the wedge too.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check sfepy==2026.3 numpy==2.4.6

venv/bin/python - <<'END'
from sfepy.discrete import Integral

volumes = {}
for order in range(1, 8):
    points, weights = Integral("i", order=order).get_qp("3_6")
    volumes[order] = float(weights.sum())
    outside = int((points[:, 0] + points[:, 1] > 1 + 1e-12).sum())
    print(f"order {order}: {len(points):2} points, {outside:2} of them outside; volume {volumes[order]:.4f} instead of 0.5")
assert all(abs(volumes[order] - 0.5) < 1e-12 for order in (1, 2, 3)), volumes
assert all(abs(volumes[order] - 1.0) < 1e-12 for order in (4, 5, 6, 7)), volumes
END
