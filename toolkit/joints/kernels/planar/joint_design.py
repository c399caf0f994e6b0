"""Joints in the plane in the compiled loop: partial derivatives of their rows and forces by the design."""

import numpy as np

from toolkit.foundation.kernel import inlined
from toolkit.joints.kernels.planar.joint_jacobian import direction_force, direction_rows
from toolkit.joints.kernels.planar.joint_kernel import change_number
from toolkit.markers.planar.marker_forces import add_force, add_force_design


@inlined
def joint_design(joints, j, markers, state, q, acc, curve_variable, curve_index, curve_x, levels, work, I_x, A_x):
    """Partial derivatives of the residual by the design: markers, numbers of the forms, time curve."""
    for side in range(2):
        m = joints.marker[j, side]
        frame = markers.frame[m]
        c, s = (np.cos(q[frame + 2]), np.sin(q[frame + 2])) if frame >= 0 else (1 + 0 * q[0], 0 * q[0])
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            x, y = markers.design_variable[d], state.y_x[d]
            direction_rows(joints, j, 3 * side, y, state.rate_x[d], state.acceleration_x[d], state.centripetal_x[d], levels, work)
            for i in range(joints.n_rows[j]):
                I_x[joints.row[j] + i, x] += work.row[0, i]
                A_x[joints.row[j] + i, x] += work.row[1, i]
            if joints.curved[j]:
                direction_force(3 * side, y, work)
                add_forces(joints, j, markers, state, work, x, I_x)
            add_force_design(markers, state, m, d, work.force[3 * side : 3 * side + 3], 1.0, c, s, I_x)
    for d in range(joints.design_start[j], joints.design_start[j + 1]):
        x, i = joints.design[d, 0], joints.design[d, 1]
        change_number(joints, j, d, acc[joints.row[j] + i], levels, work)
        I_x[joints.row[j] + i, x] += work.row[0, i]
        A_x[joints.row[j] + i, x] += work.row[1, i]
        add_forces(joints, j, markers, state, work, x, I_x)
    last = joints.row[j] + joints.n_rows[j] - 1
    for d in range(len(curve_index)):
        if curve_index[d] == joints.curve[j]:
            f = curve_x[d]
            A_x[last, curve_variable[d]] -= levels[0] * f[2] + levels[1] * f[1] + levels[2] * f[0]


@inlined
def add_forces(joints, j, markers, state, work, x, I_x):
    """What a change of g_z^T lam adds on both markers."""
    for side in range(2):
        add_force(markers, state, joints.marker[j, side], work.dforce[3 * side : 3 * side + 3], 1.0, I_x[:, x])
