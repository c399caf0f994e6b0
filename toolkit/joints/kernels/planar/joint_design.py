"""Joints in the plane in the compiled loop: partial derivatives of their rows and forces by the design."""

from toolkit.foundation.kernel import inlined
from toolkit.joints.kernels.planar.joint_jacobian import direction_force, direction_rows
from toolkit.joints.kernels.planar.joint_kernel import change_number
from toolkit.joints.kernels.records import CURVE, CURVED, DESIGN, FIRST_ROW, N_ROWS
from toolkit.markers.planar.marker_forces import add_force, add_force_design
from toolkit.markers.planar.marker_kernel import known_turn


@inlined
def joint_design(joints, j, markers, state, acc, curve_variable, curve_index, curve_x, levels, work, I_x, A_x):
    """Partial derivatives of the residual by the design: markers, numbers of the forms, time curve."""
    for side in range(2):
        m = joints.of[j, side]
        c, s = known_turn(markers, state, m)
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            x, y = markers.design_variable[d], state.y_x[d]
            direction_rows(joints, j, 3 * side, y, state.rate_x[d], state.acceleration_x[d], state.centripetal_x[d], levels, work)
            for i in range(joints.of[j, N_ROWS]):
                I_x[joints.of[j, FIRST_ROW] + i, x] += work.row[0, i]
                A_x[joints.of[j, FIRST_ROW] + i, x] += work.row[1, i]
            if joints.of[j, CURVED]:
                direction_force(3 * side, y, work)
                add_forces(joints, j, markers, state, work, x, I_x)
            add_force_design(markers, state, m, d, work.force[0, 3 * side : 3 * side + 3], 1.0, c, s, I_x)
    for d in range(joints.of[j, DESIGN], joints.of[j, DESIGN + 1]):
        x, i = joints.design[d, 0], joints.design[d, 1]
        change_number(joints, j, d, acc[joints.of[j, FIRST_ROW] + i], levels, work)
        I_x[joints.of[j, FIRST_ROW] + i, x] += work.row[0, i]
        A_x[joints.of[j, FIRST_ROW] + i, x] += work.row[1, i]
        add_forces(joints, j, markers, state, work, x, I_x)
    last = joints.of[j, FIRST_ROW] + joints.of[j, N_ROWS] - 1
    for d in range(len(curve_index)):
        if curve_index[d] == joints.of[j, CURVE]:
            f = curve_x[d]
            A_x[last, curve_variable[d]] -= levels[0] * f[2] + levels[1] * f[1] + levels[2] * f[0]


@inlined
def add_forces(joints, j, markers, state, work, x, I_x):
    """Add to both markers what a change of g_z^T lam brings."""
    for side in range(2):
        add_force(markers, state, joints.of[j, side], work.force[1, 3 * side : 3 * side + 3], 1.0, I_x[:, x])
