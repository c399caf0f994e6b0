"""Joints in the compiled loop: derivatives of their rows and forces by the state, direction by direction.

A direction is a coordinate or a design variable of one marker, given by its derivatives of y, B v, B a and b (see `joint_kernel`).
"""

from toolkit.foundation.kernel import inlined
from toolkit.joints.kernels.records import CURVED, N_ROWS, POSITION
from toolkit.markers.planar.marker_forces import add_geometric_stiffness


@inlined
def direction_rows(joints, j, first, y, rate, acceleration, centripetal, levels, work):
    """Derivatives of the constraint rows in one direction, given its derivatives of y, B v, B a and b.

    `first` is the first of the three numbers z that it moves. For a coordinate's direction (y, rate) = (B, B_v), and row 2 is the
    derivative by its velocity: k_2 (g_z 2 B_v + 2 w^T g_zz B) + k_1 g_z B.
    """
    k2, k1, k0 = levels[0], levels[1], levels[2]
    for i in range(joints.of[j, N_ROWS]):
        inertial, total, velocity, position, bent = 0 * y[0], 0 * y[0], 0 * y[0], 0 * y[0], 0 * y[0]
        for c in range(3):
            g = work.slope[i, 0, first + c]
            inertial += g * acceleration[c]
            total += g * centripetal[c]
            velocity += g * rate[c]
            position += g * y[c]
        if joints.of[j, CURVED]:
            for c in range(3):
                k = first + c
                inertial += work.slope[i, 2, k] * y[c]
                total += work.slope[i, 3, k] * y[c] + 2 * work.slope[i, 1, k] * rate[c]
                bent += work.slope[i, 1, k] * y[c]
        work.row[0, i] = k2 * inertial
        work.row[1, i] = k2 * total + k1 * (velocity + bent) + k0 * position
        work.row[2, i] = 2 * k2 * (velocity + bent) + k1 * position
        work.row[3, i] = position


@inlined
def direction_force(first, y, work):
    """Derivative of g_z^T lam in one direction at constant lam."""
    for k in range(6):
        work.force[1, k] = 0
        for c in range(3):
            work.force[1, k] += work.stiffness[k, first + c] * y[c]


@inlined
def translation(joints, j, k, column, n, by_row, by_column, levels, work, I_acc, A_q, A_v):
    """Derivatives of linear constraint rows by coordinate number `column` of the joint, which moves number k of the poses alone.

    They are what `direction_rows` comes to.
    """
    rows = joints.of[j, N_ROWS]
    for i in range(rows):
        g = work.slope[i, 0, k]
        if g != 0:
            at = by_row[i * n + column]
            I_acc[at] += levels[0] * g
            I_acc[by_column[column * rows + i]] += g
            A_q[at] += levels[2] * g
            A_v[at] += levels[1] * g


@inlined
def joint_jacobian(joints, j, markers, state, levels, work, I_acc, I_q, A_q, A_v):
    """Derivatives of the residual by q, v, a and lam, scattered into the pattern."""
    a, b = joints.of[j, 0], joints.of[j, 1]
    n_a = markers.start[a + 1] - markers.start[a]
    n = n_a + markers.start[b + 1] - markers.start[b]
    rows = joints.of[j, N_ROWS]
    position = joints.position[joints.of[j, POSITION] :]
    by_row, by_column = position[n * n :], position[n * n + rows * n :]
    for side in range(2):
        m = joints.of[j, side]
        for k in range(markers.start[m], markers.start[m + 1]):
            local = k - markers.start[m] + side * n_a
            if k < markers.start[m] + 2 and markers.frame[m] >= 0 and not joints.of[j, CURVED]:
                number = 3 * side + k - markers.start[m]
                translation(joints, j, number, local, n, by_row, by_column, levels, work, I_acc, A_q, A_v)
                continue
            direction_rows(joints, j, 3 * side, state.B[k], state.B_v[k], state.B_a[k], state.b_q[k], levels, work)
            for i in range(rows):
                at, transposed = by_row[i * n + local], by_column[local * rows + i]
                I_acc[at] += levels[0] * work.row[3, i]
                I_acc[transposed] += work.row[3, i]
                I_q[at] += work.row[0, i]
                A_q[at] += work.row[1, i]
                A_v[at] += work.row[2, i]
            if joints.of[j, CURVED]:
                direction_force(3 * side, state.B[k], work)
                curvature_column(joints, j, markers, state, local, n, n_a, position, work, I_q)
        add_geometric_stiffness(markers, state, m, work.force[0, 3 * side : 3 * side + 3], 1.0, position, n, side * n_a, I_q)


@inlined
def curvature_column(joints, j, markers, state, local, n, n_a, position, work, I_q):
    """B^T (lam . g_zz) B, one column."""
    for side in range(2):
        m = joints.of[j, side]
        for k in range(markers.start[m], markers.start[m + 1]):
            entry = 0 * work.pose[0, 0]
            for c in range(3):
                entry += state.B[k, c] * work.force[1, 3 * side + c]
            I_q[position[(k - markers.start[m] + side * n_a) * n + local]] += entry
