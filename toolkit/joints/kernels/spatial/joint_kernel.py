"""All spatial joints in the compiled loop: quadratic forms of the poses of two markers, at acceleration level and stabilized.

A pose is four vectors (position and axes, see `bodies.spatial.marker_kernel`); z holds those of markers a and b, X_0 ... X_7.
Every row of a joint is a form, or a law of forms (see `composition`), such as the angle atan2(h_2, h_1):

    h(z) = constant + sum linear * (component of X_i) + sum value * X_i . X_j

So h_zz is constant and its third derivative zero. Rows of the residual are those of planar joints (see `planar.joint_kernel`), with g_z,
g_zz and d(w^T g_zz w)/dz from here.
"""

from toolkit.foundation.kernel import inlined, inner, kernel
from toolkit.joints.kernels.composition import change_row, compose, gap
from toolkit.joints.kernels.laws import FORMS, PLAIN, PROFILE
from toolkit.joints.kernels.profile import VALUES, carrier, change_profile, of_profile, read_profile
from toolkit.joints.kernels.records import CONSTANT, CURVE, FIRST_ROW, FORM, LAW, LINEAR, N_ROWS, PHI
from toolkit.joints.kernels.records import SPATIAL_NUMBERS as NUMBERS
from toolkit.joints.kernels.records import SPATIAL_ROWS as ROWS
from toolkit.markers.spatial.marker_forces import add_spatial_force


@inner
def dot_pair(a, i, b, j):
    """Scalar product of vector i of a and vector j of b."""
    return a[3 * i] * b[3 * j] + a[3 * i + 1] * b[3 * j + 1] + a[3 * i + 2] * b[3 * j + 2]


@inner
def add_pair(value, i, j, source, target):
    """target += value d(X_i . X_j)/dz [source], the pair's second derivative in one direction."""
    for c in range(3):
        target[3 * i + c] += value * source[3 * j + c]
        target[3 * j + c] += value * source[3 * i + c]


@inlined
def evaluate_form(joints, form, pose, slope):
    """Value of one form; its derivatives are filled."""
    slope[:, :] = 0
    first, pairs, last = joints.start[form, 0], joints.start[form, 1], joints.start[form + 1, 0]
    total = joints.value[first] + 0 * pose[0, 0]
    for e in range(first + 1, pairs):
        total += joints.value[e] * pose[0, joints.place[e]]
        slope[0, joints.place[e]] += joints.value[e]
    for e in range(pairs, last, 2):
        total += add_product(joints.place[e], joints.place[e + 1], joints.value[e], pose, slope)
    return total


@inlined
def add_product(i, k, factor, pose, slope):
    """Value of factor X_i . X_k; its derivatives are added."""
    for direction in range(4):
        add_pair(factor, i, k, pose[direction], slope[direction])
    return factor * dot_pair(pose[0], i, pose[0], k)


@kernel
def evaluate_spatial_joint(functions, joints, j, state, acc, work):
    """Compute all rows of one joint with their derivatives at the poses of the two markers, and its force g_z^T lam."""
    pose = work.pose
    for side in range(2):
        m = joints.of[j, side]
        for k in range(12):
            at = 12 * side + k
            pose[0, at], pose[1, at] = state.y[m, k], state.rate[m, k]
            pose[2, at], pose[3, at] = state.acceleration[m, k], state.centripetal[m, k]
    form = joints.of[j, FORM]
    work.force[0] = 0
    for i in range(joints.of[j, N_ROWS]):
        if joints.of[j, LAW + 2 * i] == PLAIN:
            work.row[PHI, i] = evaluate_form(joints, form, pose, work.slope[i])
            work.composed[i, 0, 0] = 1
        else:
            composed_row(functions, joints, j, i, form, work)
        form += joints.of[j, LAW + 1 + 2 * i]
        for k in range(NUMBERS):
            work.force[0, k] += work.slope[i, 0, k] * acc[joints.of[j, FIRST_ROW] + i]


@inner
def composed_row(functions, joints, j, i, form, work):
    """Evaluate a row that is a law of forms."""
    n = joints.of[j, LAW + 1 + 2 * i]
    carried = 1 if joints.of[j, LAW + 2 * i] == PROFILE else 0
    for f in range(n - carried):
        work.law[0, f] = evaluate_form(joints, form + f, work.pose, work.forms[f, :4])
    if carried:
        work.forms[n - 1, :4] = 0
        read_profile(joints, form + n - 1, n, work.law[0], work.law[VALUES])
    compose(functions, joints.of[j, LAW + 2 * i], n, i, work)


@kernel
def change_spatial_number(joints, j, d, lam, levels, work):
    """Derivatives of a row and of its force by a number of its forms, see `change_row`."""
    kind, place, value, h = joints.design[d, 3], joints.design[d, 4], joints.design_value[d, 0], work.forms[FORMS]
    h[:4, :] = 0
    if of_profile(joints, j, d):
        change_profile(joints, j, d, carrier(joints, j, d), lam, levels, work)
        return
    if kind == CONSTANT:
        work.law[0, FORMS] = value
    elif kind == LINEAR:
        work.law[0, FORMS] = value * work.pose[0, joints.place[place]]
        h[0, joints.place[place]] = value
    else:
        work.law[0, FORMS] = add_product(joints.place[place], joints.place[place + 1], value, work.pose, h[:4])
    change_row(joints, j, d, lam, levels, work)


@inner
def spatial_joint_residual(joints, j, markers, state, curves, levels, work, inertial, applied):
    """Add the constraint rows, and the constraint forces on both bodies."""
    k2, k1, k0 = levels[0], levels[1], levels[2]
    for i in range(joints.of[j, N_ROWS]):
        growth, total, rate, target = 0 * work.pose[0, 0], 0 * work.pose[0, 0], 0 * work.pose[0, 0], 0 * work.pose[0, 0]
        for e in range(joints.felt_start[ROWS * j + i], joints.felt_start[ROWS * j + i + 1]):
            for k in range(3 * joints.felt[e], 3 * joints.felt[e] + 3):
                growth += work.slope[i, 0, k] * work.pose[2, k]
                total += work.slope[i, 0, k] * work.pose[3, k] + work.slope[i, 1, k] * work.pose[1, k]
                rate += work.slope[i, 0, k] * work.pose[1, k]
        row = joints.of[j, FIRST_ROW] + i
        if joints.of[j, CURVE] >= 0 and i == joints.of[j, N_ROWS] - 1:
            f = curves[joints.of[j, CURVE]]
            target, rate, total = target + f[0], rate - f[1], total - f[2]
        inertial[row] += k2 * growth
        applied[row] += k2 * total + k1 * rate + k0 * gap(joints, j, i, work.row[PHI, i], target)
    add_spatial_force(markers, state, joints.of[j, 0], work.force[0, :12], 1.0, inertial)
    add_spatial_force(markers, state, joints.of[j, 1], work.force[0, 12:], 1.0, inertial)
