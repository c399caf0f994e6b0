"""All joints in the plane in the compiled loop: rows of forms of the poses of two markers, at acceleration level and stabilized.

A joint is g(z) - f(t) = 0 with z = (x, y, angle) of marker a and of marker b. Every row is a form (see `form_kernel`), or a law of forms
(see `composition`). With g_z, g_zz and d(w^T g_zz w)/dz for the rates w = z', its rows of the residual are

    inertial:   k_2 g_z B a
    applied:    k_2 (g_z b + w^T g_zz w - f'') + k_1 (g_z w - f') + k_0 (g - f)

with (k_2, k_1, k_0) = (1, 2 damping, stiffness^2) in dynamics (Baumgarte), (0, 0, 1) in statics; the forces g_z^T lam enter the
inertial group. Coordinates and design variables of markers are treated alike: each is a direction with its derivatives of y, B v, B a, b.
"""

import numpy as np

from toolkit.foundation.kernel import inlined, inner, kernel
from toolkit.joints.kernels.composition import change_row, compose, gap
from toolkit.joints.kernels.laws import ANGLE, FORMS, PLAIN, PROFILE
from toolkit.joints.kernels.planar.form_kernel import add_pair, contract, evaluate_form
from toolkit.joints.kernels.profile import VALUES, carrier, change_profile, of_profile, read_profile
from toolkit.joints.kernels.records import CONSTANT, CURVE, CURVED, FIRST_ROW, FORM, GRADIENT, LAW, LINEAR, N_ROWS, PHI, TURNED
from toolkit.markers.planar.marker_forces import add_force


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
        if joints.of[j, LAW + 2 * i] == PLAIN:
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
    carried = 1 if joints.of[j, LAW + 2 * i] == PROFILE else 0
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
    kind, place, value, h = joints.design[d, 3], joints.design[d, 4], joints.design_value[d], work.forms[FORMS]
    h[:, :] = 0
    if of_profile(joints, j, d):
        change_profile(joints, j, d, carrier(joints, j, d), lam, levels, work)
        return
    if kind == CONSTANT:
        work.law[0, FORMS] = value[0]
    elif kind == LINEAR:
        work.law[0, FORMS] = value[0] * work.pose[0, joints.place[place]]
        h[0, joints.place[place]] = value[0]
    else:
        i, k = joints.place[place], joints.place[place + 1]
        work.law[0, FORMS] = add_pair(i, k, value[0], value[1], work.pose, h[0], h[5:], h[4])
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
        if joints.of[j, LAW + 2 * last] == ANGLE:
            applied[row + last] += k0 * (gap(joints, j, last, work.row[PHI, last], f[0]) - (work.row[PHI, last] - f[0]))
    add_force(markers, state, joints.of[j, 0], work.force[0, :3], 1.0, inertial)
    add_force(markers, state, joints.of[j, 1], work.force[0, 3:], 1.0, inertial)
