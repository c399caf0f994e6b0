"""How far the joints of a finished run are from closed."""

import numpy as np

from toolkit.foundation.kernel import inlined, kernel
from toolkit.foundation.near_ties import BAND
from toolkit.joints.kernels.all_joints import evaluate_any_joint
from toolkit.joints.kernels.composition import gap
from toolkit.joints.kernels.planar_pin import pin_rows
from toolkit.joints.kernels.records import CURVE, FIRST_ROW, N_ROWS, PHI, PINNED
from toolkit.markers.poses import update_positions


@inlined
def find_rows(plane, frames, functions, joints, j, markers, state, rest, work):
    """Rows of one joint, in `work.row[PHI]`."""
    if plane is not None and joints.of[j, PINNED]:
        pin_rows(joints, j, state, work.row[PHI])
        return
    evaluate_any_joint(plane, frames, functions, joints, j, markers, state, rest, work)


@kernel
def largest_drift(plan, functions, curves, weights, q, rest, found, work):
    """Largest weighted |phi| over all times and rows, (value, time index, unknown, value there) in `found` (4,); `rest` is zero,
    (n,).

    The place is the first one where it is the largest but for a part `BAND` of it, see `near_ties`.
    """
    plane, frames = plan.markers.plane, plan.markers.frames
    for n in range(len(q)):
        update_positions(plane, frames, plan.markers, work.markers, q[n], rest)
        for j in range(len(plan.joints.of)):
            find_rows(plane, frames, functions[0], plan.joints, j, plan.markers, work.markers, rest, work.joint)
            rows = plan.joints.of[j, N_ROWS]
            for i in range(rows):
                target = 0.0
                if plan.joints.of[j, CURVE] >= 0 and i == rows - 1:
                    target = curves[n, plan.joints.of[j, CURVE], 0]
                value = gap(plan.joints, j, i, work.joint.row[PHI, i], target)
                row = plan.joints.of[j, FIRST_ROW] + i
                violation = weights[row] * abs(value.real)
                if not violation <= found[0] and not np.isnan(found[0]):
                    found[0] = violation
                if not violation <= (1 + BAND) * found[3] and not np.isnan(found[3]):
                    found[1], found[2], found[3] = n, row, violation
