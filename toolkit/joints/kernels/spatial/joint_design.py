"""Spatial joints in the compiled loop: partial derivatives of their rows and forces by the design."""

from toolkit.foundation.kernel import inner
from toolkit.joints.kernels.laws import PLAIN
from toolkit.joints.kernels.records import CURVE, DESIGN, FIRST_ROW, FORM, GRADIENT, LAW, N_ROWS
from toolkit.joints.kernels.spatial.joint_jacobian import bent_slopes, direction_row
from toolkit.joints.kernels.spatial.joint_kernel import NUMBERS, change_spatial_number
from toolkit.markers.spatial.marker_forces import add_spatial_force, add_spatial_force_design


@inner
def spatial_joint_design(joints, j, markers, state, acc, curve_variable, curve_index, curve_x, levels, work, I_x, A_x):
    """Partial derivatives of the residual by the design: markers, numbers of the forms, time curve."""
    for side in range(2):
        m = joints.of[j, side]
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            x = markers.design_variable[d]
            for i in range(joints.of[j, N_ROWS]):
                y, rate, acceleration, centripetal = (
                    state.y_x[d],
                    state.rate_x[d],
                    state.acceleration_x[d],
                    state.centripetal_x[d],
                )
                inertial, total, velocity, phi = direction_row(joints, j, i, side, y, rate, acceleration, centripetal, work)
                I_x[joints.of[j, FIRST_ROW] + i, x] += levels[0] * inertial
                A_x[joints.of[j, FIRST_ROW] + i, x] += levels[0] * total + levels[1] * velocity + levels[2] * phi
            direction_force(joints, j, side, state.y_x[d], acc, work)
            add_both(joints, j, markers, state, work.force[1], I_x[:, x])
            add_spatial_force_design(markers, state, m, d, work.force[0, 12 * side : 12 * side + 12], 1.0, I_x)
    for d in range(joints.of[j, DESIGN], joints.of[j, DESIGN + 1]):
        x, i = joints.design[d, 0], joints.design[d, 1]
        change_spatial_number(joints, j, d, acc[joints.of[j, FIRST_ROW] + i], levels, work)
        I_x[joints.of[j, FIRST_ROW] + i, x] += work.row[0, i]
        A_x[joints.of[j, FIRST_ROW] + i, x] += work.row[1, i]
        add_both(joints, j, markers, state, work.force[1], I_x[:, x])
    last = joints.of[j, FIRST_ROW] + joints.of[j, N_ROWS] - 1
    for d in range(len(curve_index)):
        if curve_index[d] == joints.of[j, CURVE]:
            f = curve_x[d]
            A_x[last, curve_variable[d]] -= levels[0] * f[2] + levels[1] * f[1] + levels[2] * f[0]


@inner
def direction_force(joints, j, side, y, acc, work):
    """Derivative of g_z^T lam in a direction of one marker's pose at constant lam."""
    work.force[1] = 0
    form = joints.of[j, FORM]
    for i in range(joints.of[j, N_ROWS]):
        lam = acc[joints.of[j, FIRST_ROW] + i]
        for f in range(joints.of[j, LAW + 1 + 2 * i]):
            form_force(joints, form, lam * work.composed[i, f, 0], side, y, work.force[1])
            form += 1
        if joints.of[j, LAW + 2 * i] != PLAIN:
            bent_slopes(i, joints.of[j, LAW + 1 + 2 * i], lam, side, y, work)
            for f in range(joints.of[j, LAW + 1 + 2 * i]):
                for k in range(NUMBERS):
                    work.force[1, k] += work.law[1, f] * work.composed[i, f, GRADIENT + k]


@inner
def form_force(joints, form, factor, side, y, out):
    """Add factor h_zz in a direction of one marker's pose to `out`."""
    for e in range(joints.start[form, 1], joints.start[form + 1, 0], 2):
        i, j, value = joints.place[e], joints.place[e + 1], factor * joints.value[e]
        for c in range(3):
            if j // 4 == side:
                out[3 * i + c] += value * y[3 * (j % 4) + c]
            if i // 4 == side:
                out[3 * j + c] += value * y[3 * (i % 4) + c]


@inner
def add_both(joints, j, markers, state, force, residual):
    """Add B^T force to the residual, on both markers."""
    add_spatial_force(markers, state, joints.of[j, 0], force[:12], 1.0, residual)
    add_spatial_force(markers, state, joints.of[j, 1], force[12:], 1.0, residual)
