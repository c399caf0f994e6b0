"""Spatial joints in the compiled loop: derivatives of their rows and forces by the state, direction by direction.

A direction is a coordinate or a design variable of one marker, given by its derivatives of y, B v, B a and b (see `joint_kernel`).
"""

from toolkit.foundation.kernel import inlined, inner
from toolkit.joints.kernels.spatial.joint_kernel import ROWS
from toolkit.markers.spatial.marker_forces import add_spatial_stiffness


@inlined
def direction_rows(joints, j, side, y, rate, acceleration, centripetal, levels, work):
    """Derivatives of the constraint rows in one direction of one marker, as of planar joints.

    Row 2 of `work.row` is the derivative by the coordinate's velocity: k_2 (g_z 2 B_v + 2 w^T g_zz B) + k_1 g_z B.
    """
    k2, k1, k0 = levels[0], levels[1], levels[2]
    for i in range(joints.n_rows[j]):
        inertial, total, velocity, position = 0 * y[0], 0 * y[0], 0 * y[0], 0 * y[0]
        for e in range(joints.block_start[ROWS * j + i], joints.block_start[ROWS * j + i + 1]):
            if joints.block[e] // 4 == side:
                for c in range(3):
                    z, k = 3 * joints.block[e] + c, 3 * (joints.block[e] % 4) + c
                    g, bent = work.phi_z[i, z], work.along[i, 0, z]
                    inertial += g * acceleration[k] + work.along[i, 1, z] * y[k]
                    total += g * centripetal[k] + work.along[i, 2, z] * y[k] + 2 * bent * rate[k]
                    velocity += g * rate[k] + bent * y[k]
                    position += g * y[k]
        work.row[0, i] = k2 * inertial
        work.row[1, i] = k2 * total + k1 * velocity + k0 * position
        work.row[2, i] = 2 * k2 * velocity + k1 * position
        work.row[3, i] = position


@inner
def spatial_joint_jacobian(joints, j, markers, state, levels, acc, work, I_acc, I_q, A_q, A_v):
    """Derivatives of the residual by q, v, a and lam, scattered into the pattern."""
    a, b = joints.marker[j, 0], joints.marker[j, 1]
    n_a = markers.start[a + 1] - markers.start[a]
    n = n_a + markers.start[b + 1] - markers.start[b]
    rows = joints.n_rows[j]
    position = joints.position[joints.position_start[j] :]
    by_row, by_column = position[n * n :], position[n * n + rows * n :]
    for side in range(2):
        m = joints.marker[j, side]
        for k in range(markers.start[m], markers.start[m + 1]):
            local = k - markers.start[m] + side * n_a
            direction_rows(joints, j, side, state.B[k], state.B_v[k], state.B_a[k], state.b_q[k], levels, work)
            for i in range(rows):
                at, transposed = by_row[i * n + local], by_column[local * rows + i]
                I_acc[at] += levels[0] * work.row[3, i]
                I_acc[transposed] += work.row[3, i]
                I_q[at] += work.row[0, i]
                A_q[at] += work.row[1, i]
                A_v[at] += work.row[2, i]
        add_spatial_stiffness(markers, state, m, work.force[12 * side : 12 * side + 12], 1.0, position, n, side * n_a, I_q)
    form = joints.first_form[j]
    for i in range(rows):
        lam = acc[joints.row[j] + i]
        add_pairs(joints, j, form, lam * work.slope[i, 0], markers, state, position, n, n_a, I_q)
        form += 1
        if joints.is_angle[j, i] == 1:
            add_pairs(joints, j, form, lam * work.slope[i, 1], markers, state, position, n, n_a, I_q)
            form += 1
            add_bend(joints, j, i, lam, markers, state, work, position, n, n_a, I_q)


@inner
def add_pairs(joints, j, form, factor, markers, state, position, n, n_a, I_q):
    """factor B^T h_zz B of one form."""
    for e in range(joints.pair_start[form], joints.pair_start[form + 1]):
        value = factor * joints.pair_value[e]
        side, other = joints.pair[e, 0] // 4, joints.pair[e, 1] // 4
        at, to = 3 * (joints.pair[e, 0] % 4), 3 * (joints.pair[e, 1] % 4)
        m, o = joints.marker[j, side], joints.marker[j, other]
        for k in range(markers.start[m], markers.start[m + 1]):
            row = k - markers.start[m] + side * n_a
            x, y, z = value * state.B[k, at], value * state.B[k, at + 1], value * state.B[k, at + 2]
            for c in range(markers.start[o], markers.start[o + 1]):
                column = c - markers.start[o] + other * n_a
                entry = x * state.B[c, to] + y * state.B[c, to + 1] + z * state.B[c, to + 2]
                I_q[position[row * n + column]] += entry
                I_q[position[column * n + row]] += entry


@inner
def slopes(joints, j, i, side, k, state, work):
    """h_z B of both forms of an angle for one column."""
    first, second = 0 * work.z[0], 0 * work.z[0]
    for c in range(12):
        first += work.angle_z[i, 0, 12 * side + c] * state.B[k, c]
        second += work.angle_z[i, 1, 12 * side + c] * state.B[k, c]
    return first, second


@inner
def add_bend(joints, j, i, lam, markers, state, work, position, n, n_a, I_q):
    """lam B^T (sum of g_hh h_z h_z^T) B of an angle."""
    for side in range(2):
        m = joints.marker[j, side]
        for k in range(markers.start[m], markers.start[m + 1]):
            c_row, s_row = slopes(joints, j, i, side, k, state, work)
            x = lam * (work.bend[i, 0] * c_row + work.bend[i, 1] * s_row)
            y = lam * (work.bend[i, 1] * c_row + work.bend[i, 2] * s_row)
            row = k - markers.start[m] + side * n_a
            for other in range(2):
                o = joints.marker[j, other]
                for c in range(markers.start[o], markers.start[o + 1]):
                    first, second = slopes(joints, j, i, other, c, state, work)
                    I_q[position[row * n + c - markers.start[o] + other * n_a]] += x * first + y * second
