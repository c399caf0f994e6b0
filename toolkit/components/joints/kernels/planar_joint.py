"""All joints in the plane in the compiled loop: rows of forms of the poses of two markers, at acceleration level and stabilized.

A joint is g(z) - f(t) = 0 with z = (x, y, angle) of marker a and of marker b. Every row is a form (see `planar_forms`), or a law of forms
(see `composition`). With g_z, g_zz and d(w^T g_zz w)/dz for the rates w = z', its rows of the residual are

    inertial:   k_2 g_z B a
    applied:    k_2 (g_z b + w^T g_zz w - f'') + k_1 (g_z w - f') + k_0 (g - f)

with (k_2, k_1, k_0) = (1, 2 damping, stiffness^2) in dynamics (Baumgarte), (0, 0, 1) in statics; the forces g_z^T lam enter the
inertial group. Coordinates and design variables of markers are treated alike: each is a direction with its derivatives of y, B v, B a, b.
"""

import numpy as np

from toolkit.components.joints.kernels.composition import change_row, compose, gap
from toolkit.components.joints.kernels.laws import ANGLE_LAW, MOST_FORMS, PLAIN_LAW, PROFILE_LAW
from toolkit.components.joints.kernels.planar_forms import add_pair, contract, evaluate_form
from toolkit.components.joints.kernels.profile import VALUES, carrier, change_profile, of_profile, read_profile
from toolkit.components.joints.kernels.records import (
    CONSTANT,
    CURVE,
    CURVED,
    DESIGN,
    FIRST_ROW,
    FORM,
    GRADIENT,
    LAW,
    LINEAR,
    N_ROWS,
    PHI,
    POSITION,
    TURNED,
)
from toolkit.components.markers.planar import add_force, add_force_design, add_geometric_stiffness, known_turn
from toolkit.foundation.kernel import inlined, inner, kernel


@kernel
def evaluate_planar_joint(functions, joints, j, state, acc, work):
    """g and its derivatives at the poses of the two markers, and their contractions with rates and multipliers."""
    for side in range(2):
        m = joints.of[j, side]
        for i in range(3):
            k = 3 * side + i
            work.pose[0, k], work.pose[1, k] = state.y[m, i], state.rate[m, i]
            work.pose[2, k], work.pose[3, k] = state.acceleration[m, i], state.centripetal[m, i]
    if joints.of[j, CURVED]:
        curved_joint(functions, joints, j, acc, work)
    else:
        flat_joint(joints, j, acc, work)


@inlined
def flat_joint(joints, j, acc, work):
    """Evaluate a joint whose rows are linear in the poses."""
    form = joints.of[j, FORM]
    for k in range(6):
        work.force[0, k] = 0
    for i in range(joints.of[j, N_ROWS]):
        for k in range(6):
            work.slope[i, 0, k] = 0
        lam, first = acc[joints.of[j, FIRST_ROW] + i], joints.start[form + i, 0]
        total = joints.value[first] + 0 * work.pose[0, 0]
        for e in range(first + 1, joints.start[form + i, 1]):
            k, value = joints.place[e], joints.value[e]
            total += value * work.pose[0, k]
            work.slope[i, 0, k] += value
            work.force[0, k] += value * lam
        work.row[PHI, i] = total


@inner
def curved_joint(functions, joints, j, acc, work):
    """Evaluate a joint with products of vectors or with laws."""
    pose, form = work.pose, joints.of[j, FORM]
    for side in range(2):
        if joints.of[j, TURNED + side]:
            pose[4, 2 * side], pose[4, 2 * side + 1] = np.cos(pose[0, 3 * side + 2]), np.sin(pose[0, 3 * side + 2])
    work.force[0] = 0
    work.stiffness[:, :] = 0
    for i in range(joints.of[j, N_ROWS]):
        lam = acc[joints.of[j, FIRST_ROW] + i]
        if joints.of[j, LAW + 2 * i] == PLAIN_LAW:
            plain_row(joints, i, form, lam, work)
        else:
            composed_row(functions, joints, j, i, form, lam, work)
        form += joints.of[j, LAW + 1 + 2 * i]
        for k in range(6):
            work.force[0, k] += work.slope[i, 0, k] * lam


@inlined
def plain_row(joints, i, form, lam, work):
    """Evaluate a row that is a form."""
    h_zww, h_zz = work.forms[0, 4], work.forms[0, 5:]
    work.row[PHI, i] = evaluate_form(joints, form, work.pose, work.slope[i], h_zz, h_zww)
    if joints.start[form, 1] < joints.start[form + 1, 0]:
        add_stiffness(lam, h_zz, work.stiffness)
    else:
        work.slope[i, 1:, :] = 0


@inlined
def add_stiffness(factor, h_zz, stiffness):
    """Add factor h_zz to the stiffness of the joint."""
    for k in range(6):
        for c in range(6):
            stiffness[k, c] += factor * h_zz[k, c]


@inner
def composed_row(functions, joints, j, i, form, lam, work):
    """Evaluate a row that is a law of forms."""
    n = joints.of[j, LAW + 1 + 2 * i]
    carried = 1 if joints.of[j, LAW + 2 * i] == PROFILE_LAW else 0
    for f in range(n - carried):
        h = work.forms[f]
        h[1:, :] = 0
        work.law[0, f] = evaluate_form(joints, form + f, work.pose, h[:4], h[5:], h[4])
    if carried:
        work.forms[n - 1] = 0
        read_profile(joints, form + n - 1, n, work.law[0], work.law[VALUES])
    compose(functions, joints.of[j, LAW + 2 * i], n, i, work)
    for f in range(n):
        add_stiffness(lam * work.composed[i, f, 0], work.forms[f, 5:], work.stiffness)
        for g in range(n):
            for k in range(6):
                factor = lam * work.composed[i, f, 5 + g] * work.composed[i, f, GRADIENT + k]
                for c in range(6):
                    work.stiffness[k, c] += factor * work.composed[i, g, GRADIENT + c]


@kernel
def change_number(joints, j, d, lam, levels, work):
    """Derivatives of a row and of its force by a number of its forms, see `change_row`."""
    kind, place, value, h = joints.design[d, 3], joints.design[d, 4], joints.design_value[d], work.forms[MOST_FORMS]
    h[:, :] = 0
    if of_profile(joints, j, d):
        change_profile(joints, j, d, carrier(joints, j, d), lam, levels, work)
        return
    if kind == CONSTANT:
        work.law[0, MOST_FORMS] = value[0]
    elif kind == LINEAR:
        work.law[0, MOST_FORMS] = value[0] * work.pose[0, joints.place[place]]
        h[0, joints.place[place]] = value[0]
    else:
        i, k = joints.place[place], joints.place[place + 1]
        work.law[0, MOST_FORMS] = add_pair(i, k, value[0], value[1], work.pose, h[0], h[5:], h[4])
        contract(work.pose, h[5:], h[4], h[:4])
    change_row(joints, j, d, lam, levels, work)


@inlined
def joint_residual(joints, j, markers, state, curves, levels, work, inertial, applied):
    """Add the constraint rows, and the constraint forces on both bodies."""
    row, k2, k1, k0 = joints.of[j, FIRST_ROW], levels[0], levels[1], levels[2]
    for i in range(joints.of[j, N_ROWS]):
        rows_a, total, rate = 0 * work.pose[0, 0], 0 * work.pose[0, 0], 0 * work.pose[0, 0]
        for c in range(3):
            g_a, g_b = work.slope[i, 0, c], work.slope[i, 0, 3 + c]
            rows_a += g_a * work.pose[2, c] + g_b * work.pose[2, 3 + c]
            total += g_a * work.pose[3, c] + g_b * work.pose[3, 3 + c]
            rate += g_a * work.pose[1, c] + g_b * work.pose[1, 3 + c]
            if joints.of[j, CURVED]:
                total += work.slope[i, 1, c] * work.pose[1, c] + work.slope[i, 1, 3 + c] * work.pose[1, 3 + c]
        inertial[row + i] += k2 * rows_a
        applied[row + i] += k2 * total + k1 * rate + k0 * work.row[PHI, i]
    if joints.of[j, CURVE] >= 0:
        f, last = curves[joints.of[j, CURVE]], joints.of[j, N_ROWS] - 1
        applied[row + last] -= k2 * f[2] + k1 * f[1] + k0 * f[0]
        if joints.of[j, LAW + 2 * last] == ANGLE_LAW:
            applied[row + last] += k0 * (gap(joints, j, last, work.row[PHI, last], f[0]) - (work.row[PHI, last] - f[0]))
    add_force(markers, state, joints.of[j, 0], work.force[0, :3], 1.0, inertial)
    add_force(markers, state, joints.of[j, 1], work.force[0, 3:], 1.0, inertial)


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
