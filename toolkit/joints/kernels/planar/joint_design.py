"""Joints in the compiled loop: partial derivatives of their rows and forces by the design."""

import numpy as np

from toolkit.foundation.kernel import inlined
from toolkit.joints.kernels.planar.joint_jacobian import direction_force, direction_rows
from toolkit.markers.planar.marker_forces import add_force, add_force_design


@inlined
def joint_design(joints, j, markers, state, q, curve_variable, curve_index, curve_x, levels, work, I_x, A_x):
    """Partial derivatives of the residual by the design: markers, parameters, time curve."""
    for side in range(2):
        m = joints.marker[j, side]
        frame = markers.frame[m]
        c, s = (np.cos(q[frame + 2]), np.sin(q[frame + 2])) if frame >= 0 else (1 + 0 * q[0], 0 * q[0])
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            y, rate, acceleration, centripetal = state.y_x[d], state.rate_x[d], state.acceleration_x[d], state.centripetal_x[d]
            direction_rows(joints, j, 3 * side, 3, y, rate, acceleration, centripetal, levels, work)
            add_direction(joints, j, markers, state, 3 * side, 3, y, markers.design_variable[d], work, I_x, A_x)
            add_force_design(markers, state, m, d, work.force[3 * side : 3 * side + 3], 1.0, c, s, I_x)
    y, still = work.unit[0], work.unit[1]
    for d in range(joints.design_start[j], joints.design_start[j + 1]):
        y[0] = joints.design_value[d]
        first = 6 + joints.design_parameter[d]
        direction_rows(joints, j, first, 1, y, still, still, still, levels, work)
        add_direction(joints, j, markers, state, first, 1, y, joints.design_variable[d], work, I_x, A_x)
    last = joints.row[j] + joints.n_rows[j] - 1
    for d in range(len(curve_index)):
        if curve_index[d] == joints.curve[j]:
            f = curve_x[d]
            A_x[last, curve_variable[d]] -= levels[0] * f[2] + levels[1] * f[1] + levels[2] * f[0]


@inlined
def add_direction(joints, j, markers, state, first, size, y, x, work, I_x, A_x):
    """Rows and forces of one design direction."""
    for i in range(joints.n_rows[j]):
        I_x[joints.row[j] + i, x] += work.row[0, i]
        A_x[joints.row[j] + i, x] += work.row[1, i]
    if joints.curved[j]:
        direction_force(first, size, y, work)
        for side in range(2):
            add_force(markers, state, joints.marker[j, side], work.dforce[3 * side : 3 * side + 3], 1.0, I_x[:, x])
