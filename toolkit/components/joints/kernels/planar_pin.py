"""Pins in the compiled loop: two points of the plane coincide, r_a = r_b, which is what most planar joints are.

The general formulas (`planar_joint`) for g = (x_a - x_b, y_a - y_b), whose derivatives by the poses are 1 and -1.
"""

from toolkit.components.joints.kernels.records import FIRST_ROW, POSITION
from toolkit.components.markers.planar import add_force_design, add_geometric_stiffness, known_turn
from toolkit.foundation.kernel import inlined, inner


@inlined
def pin_rows(joints, j, state, rows):
    """Compute the rows r_a - r_b of a pin."""
    for i in range(2):
        rows[i] = state.y[joints.of[j, 0], i] - state.y[joints.of[j, 1], i]


@inlined
def add_pin(joints, j, markers, state, acc, levels, inertial, applied):
    """Add the constraint rows of a pin, and its constraint forces on both bodies."""
    a, b, row = joints.of[j, 0], joints.of[j, 1], joints.of[j, FIRST_ROW]
    for i in range(2):
        position, rate = state.y[a, i] - state.y[b, i], state.rate[a, i] - state.rate[b, i]
        total = state.centripetal[a, i] - state.centripetal[b, i]
        inertial[row + i] += levels[0] * (state.acceleration[a, i] - state.acceleration[b, i])
        applied[row + i] += levels[0] * total + levels[1] * rate + levels[2] * position
    pull(markers, state, a, acc[row], acc[row + 1], inertial)
    pull(markers, state, b, -acc[row], -acc[row + 1], inertial)


@inlined
def pull(markers, state, m, x, y, inertial):
    """Add a force (x, y) on a marker, as `add_force`."""
    first, frame = markers.start[m], markers.frame[m]
    if frame >= 0:
        inertial[frame] += x
        inertial[frame + 1] += y
        first += 2
    for k in range(first, markers.start[m + 1]):
        inertial[markers.coordinate[k]] += state.B[k, 0] * x + state.B[k, 1] * y


@inlined
def pin_jacobian(joints, j, markers, state, acc, levels, work, I_acc, I_q, A_q, A_v):
    """Derivatives by q, v, a and lam, scattered into the pattern; entries in rows and columns of a joint are its alone."""
    row, k2, k1, k0 = joints.of[j, FIRST_ROW], levels[0], levels[1], levels[2]
    n_a = markers.start[joints.of[j, 0] + 1] - markers.start[joints.of[j, 0]]
    n = n_a + markers.start[joints.of[j, 1] + 1] - markers.start[joints.of[j, 1]]
    position = joints.position[joints.of[j, POSITION] :]
    by_row, by_column, sign, local = position[n * n :], position[n * n + 2 * n :], 1.0, 0
    for side in range(2):
        m = joints.of[j, side]
        first, last = markers.start[m], markers.start[m + 1]
        offset = local
        if markers.frame[m] >= 0:
            for i in range(2):
                at = by_row[i * n + local + i]
                I_acc[at], I_acc[by_column[2 * (local + i) + i]] = k2 * sign, sign
                A_q[at], A_v[at] = k0 * sign, k1 * sign
            first += 2
            local += 2
        for k in range(first, last):
            for i in range(2):
                at, by_q = by_row[i * n + local], sign * state.B[k, i]
                by_v = sign * state.B_v[k, i]
                I_acc[at], I_acc[by_column[2 * local + i]] = k2 * by_q, by_q
                I_q[at] = k2 * sign * state.B_a[k, i]
                A_q[at] = k2 * sign * state.b_q[k, i] + k1 * by_v + k0 * by_q
                A_v[at] = 2 * k2 * by_v + k1 * by_q
            local += 1
        work.force[0, 0], work.force[0, 1] = sign * acc[row], sign * acc[row + 1]
        add_geometric_stiffness(markers, state, m, work.force[0], 1.0, position, n, offset, I_q)
        sign = -1.0


@inlined
def pin_design(joints, j, markers, state, acc, levels, work, I_x, A_x):
    """Partial derivatives by the design, which moves its two points alone."""
    row, sign = joints.of[j, FIRST_ROW], 1.0
    for side in range(2):
        m = joints.of[j, side]
        c, s = known_turn(markers, state, m)
        work.force[0, 0], work.force[0, 1], work.force[0, 2] = sign * acc[row], sign * acc[row + 1], 0
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            x = markers.design_variable[d]
            for i in range(2):
                total = levels[0] * state.centripetal_x[d, i] + levels[1] * state.rate_x[d, i] + levels[2] * state.y_x[d, i]
                I_x[row + i, x] += levels[0] * sign * state.acceleration_x[d, i]
                A_x[row + i, x] += sign * total
            add_force_design(markers, state, m, d, work.force[0], 1.0, c, s, I_x)
        sign = -1.0


@inner
def pull_pin(joints, j, side, markers, state, levels, factor_i, factor_a, q, v, acc, block, points, shapes):
    """Derivatives of mu^T (factor_i I + factor_a A) by z0 and Z of one of the two points, added to `points` and `shapes`.

    The formulas of `pin_design` backwards: with u = z0 + Z c, L = A^T mu of the rows, P = J^T L and F = A^T (force on the point)

        by u:  factor_i (k_2 alpha P + mu_theta J^T F) + factor_a ((k_0 - k_2 omega^2) L + k_1 omega P)
        by u': factor_a (k_1 L + 2 k_2 omega P)         by u'': factor_i k_2 L         by Z_c: factor_i mu_c F besides
    """
    m, row, sign = joints.of[j, side], joints.of[j, FIRST_ROW], 1.0 - 2.0 * side
    (c, s), frame, k2, k1, k0 = known_turn(markers, state, m), markers.frame[m], levels[0], levels[1], levels[2]
    omega, alpha = (v[frame + 2], acc[frame + 2]) if frame >= 0 else (0.0, 0.0)
    f_x, f_y = sign * (c * acc[row] + s * acc[row + 1]), sign * (c * acc[row + 1] - s * acc[row])
    by_l, by_p, twice = (
        factor_a * (k0 - k2 * omega * omega),
        factor_i * k2 * alpha + factor_a * k1 * omega,
        2 * factor_a * k2 * omega,
    )
    for r in range(points.shape[2]):
        x, y = sign * (c * block[row, r] + s * block[row + 1, r]), sign * (c * block[row + 1, r] - s * block[row, r])
        turn = factor_i * block[frame + 2, r] if frame >= 0 else 0.0
        u_x, u_y = by_l * x + by_p * y + turn * f_y, by_l * y - by_p * x - turn * f_x
        points[m, 0, r] += u_x
        points[m, 1, r] += u_y
        for k in range(markers.start[m] + 3 if frame >= 0 else markers.start[m], markers.start[m + 1]):
            i = markers.coordinate[k]
            by_rate, by_growth, pulled = factor_a * k1 * v[i] + factor_i * k2 * acc[i], twice * v[i], factor_i * block[i, r]
            shapes[k, 0, r] += u_x * q[i] + by_rate * x + by_growth * y + pulled * f_x
            shapes[k, 1, r] += u_y * q[i] + by_rate * y - by_growth * x + pulled * f_y
