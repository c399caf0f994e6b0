"""Spatial joints in the compiled loop: partial derivatives of their rows and forces by the design."""

from toolkit.foundation.kernel import inner
from toolkit.joints.kernels.spatial.joint_jacobian import direction_rows
from toolkit.joints.kernels.spatial.joint_kernel import NUMBERS, add_pair, dot_pair
from toolkit.markers.spatial.marker_forces import add_spatial_force, add_spatial_force_design


@inner
def spatial_joint_design(joints, j, markers, state, acc, curve_variable, curve_index, curve_x, levels, work, I_x, A_x):
    """Partial derivatives of the residual by the design: markers, numbers of the forms, time curve."""
    for side in range(2):
        m = joints.marker[j, side]
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            x = markers.design_variable[d]
            direction_rows(
                joints, j, side, state.y_x[d], state.rate_x[d], state.acceleration_x[d], state.centripetal_x[d], levels, work
            )
            for i in range(joints.n_rows[j]):
                I_x[joints.row[j] + i, x] += work.row[0, i]
                A_x[joints.row[j] + i, x] += work.row[1, i]
            direction_force(joints, j, side, state.y_x[d], acc, work)
            add_both(joints, j, markers, state, work.dforce, I_x[:, x])
            add_spatial_force_design(markers, state, m, d, work.force[12 * side : 12 * side + 12], 1.0, I_x)
    for d in range(joints.design_start[j], joints.design_start[j + 1]):
        number_design(joints, j, d, markers, state, acc, levels, work, I_x, A_x)
    last = joints.row[j] + joints.n_rows[j] - 1
    for d in range(len(curve_index)):
        if curve_index[d] == joints.curve[j]:
            f = curve_x[d]
            A_x[last, curve_variable[d]] -= levels[0] * f[2] + levels[1] * f[1] + levels[2] * f[0]


@inner
def direction_force(joints, j, side, y, acc, work):
    """Derivative of g_z^T lam in a direction of one marker's pose at constant lam."""
    work.dforce[:] = 0
    form = joints.first_form[j]
    for i in range(joints.n_rows[j]):
        lam = acc[joints.row[j] + i]
        form_force(joints, form, lam * work.slope[i, 0], side, y, work.dforce)
        form += 1
        if joints.is_angle[j, i] == 1:
            form_force(joints, form, lam * work.slope[i, 1], side, y, work.dforce)
            form += 1
            first, second = 0 * y[0], 0 * y[0]
            for c in range(12):
                first += work.angle_z[i, 0, 12 * side + c] * y[c]
                second += work.angle_z[i, 1, 12 * side + c] * y[c]
            in_first = lam * (work.bend[i, 0] * first + work.bend[i, 1] * second)
            in_second = lam * (work.bend[i, 1] * first + work.bend[i, 2] * second)
            for k in range(NUMBERS):
                work.dforce[k] += in_first * work.angle_z[i, 0, k] + in_second * work.angle_z[i, 1, k]


@inner
def form_force(joints, form, factor, side, y, out):
    """out += factor h_zz in a direction of one marker's pose."""
    for e in range(joints.pair_start[form], joints.pair_start[form + 1]):
        i, j, value = joints.pair[e, 0], joints.pair[e, 1], factor * joints.pair_value[e]
        for c in range(3):
            if j // 4 == side:
                out[3 * i + c] += value * y[3 * (j % 4) + c]
            if i // 4 == side:
                out[3 * j + c] += value * y[3 * (i % 4) + c]


@inner
def add_both(joints, j, markers, state, force, residual):
    """residual += B^T force, on both markers."""
    add_spatial_force(markers, state, joints.marker[j, 0], force[:12], 1.0, residual)
    add_spatial_force(markers, state, joints.marker[j, 1], force[12:], 1.0, residual)


@inner
def number_design(joints, j, d, markers, state, acc, levels, work, I_x, A_x):
    """Derivative by a number of a plain row: its constant, a linear term or a pair."""
    x, value, at = joints.design_variable[d], joints.design_value[d], joints.design_place[d]
    row = joints.row[j] + joints.design_row[d]
    k2, k1, k0 = levels[0], levels[1], levels[2]
    work.dforce[:] = 0
    if joints.design_kind[d] == 0:
        A_x[row, x] += k0 * value
    elif joints.design_kind[d] == 1:
        k = joints.linear_place[at]
        I_x[row, x] += k2 * value * work.acceleration[k]
        A_x[row, x] += value * (k2 * work.centripetal[k] + k1 * work.w[k] + k0 * work.z[k])
        work.dforce[k] += value * acc[row]
    else:
        i, o, z, w = joints.pair[at, 0], joints.pair[at, 1], work.z, work.w
        growth = dot_pair(z, i, work.acceleration, o) + dot_pair(work.acceleration, i, z, o)
        total = dot_pair(z, i, work.centripetal, o) + dot_pair(work.centripetal, i, z, o) + 2 * dot_pair(w, i, w, o)
        rate = dot_pair(z, i, w, o) + dot_pair(w, i, z, o)
        I_x[row, x] += k2 * value * growth
        A_x[row, x] += value * (k2 * total + k1 * rate + k0 * dot_pair(z, i, z, o))
        add_pair(value * acc[row], i, o, z, work.dforce)
    add_both(joints, j, markers, state, work.dforce, I_x[:, x])
