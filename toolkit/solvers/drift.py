"""How far the joints of a finished run are from closed."""

import numpy as np

from toolkit.bodies.marker_kernel import update_markers
from toolkit.joints.joint_kernel import evaluate_joint
from toolkit.kernel import kernel


@kernel
def largest_drift(plan, functions, curves, weights, q, rest, found, work):
    """Largest weighted |phi| over all times and rows: (value, time index, unknown) in `found`; `rest` is zero, (n,)."""
    for n in range(len(q)):
        update_markers(plan.markers, work.markers, q[n], rest, rest, work.scratch)
        for j in range(len(plan.joints.family)):
            evaluate_joint(functions[0], plan.joints, j, plan.markers, work.markers, rest, work.joint)
            rows = plan.joints.n_rows[j]
            for i in range(rows):
                value = work.joint.phi[i]
                if plan.joints.curve[j] >= 0 and i == rows - 1:
                    value -= curves[n, plan.joints.curve[j], 0]
                row = plan.joints.row[j] + i
                violation = weights[row] * abs(value.real)
                if not violation <= found[0] and not np.isnan(found[0]):
                    found[0], found[1], found[2] = violation, n, row
