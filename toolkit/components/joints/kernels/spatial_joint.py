"""All spatial joints in the compiled loop: quadratic forms of the poses of two markers, at acceleration level and stabilized.

A pose is four vectors (position and axes, see `markers.spatial`); z holds those of markers a and b, X_0 ... X_7.
Every row of a joint is a form, or a law of forms (see `composition`), such as the angle atan2(h_2, h_1):

    h(z) = constant + sum linear * (component of X_i) + sum value * X_i . X_j

So h_zz is constant and its third derivative zero. Rows of the residual are those of planar joints (see `planar_joint`), with g_z,
g_zz and d(w^T g_zz w)/dz from here.
A direction of a derivative is a coordinate or a design variable of one marker, as in the plane.
"""

from toolkit.components.joints.kernels.composition import change_row, compose, gap
from toolkit.components.joints.kernels.laws import MOST_FORMS, PLAIN_LAW, PROFILE_LAW
from toolkit.components.joints.kernels.profile import VALUES, carrier, change_profile, of_profile, read_profile
from toolkit.components.joints.kernels.records import (
    CONSTANT,
    CURVE,
    DESIGN,
    FIRST_ROW,
    FORM,
    GRADIENT,
    LAW,
    LINEAR,
    N_ROWS,
    PHI,
    POSITION,
)
from toolkit.components.joints.kernels.records import SPATIAL_NUMBERS as NUMBERS
from toolkit.components.joints.kernels.records import SPATIAL_ROWS as ROWS
from toolkit.components.markers.spatial import add_spatial_force, add_spatial_force_design, add_spatial_stiffness
from toolkit.foundation.kernel import inlined, inner, kernel


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
        if joints.of[j, LAW + 2 * i] == PLAIN_LAW:
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
    carried = 1 if joints.of[j, LAW + 2 * i] == PROFILE_LAW else 0
    for f in range(n - carried):
        work.law[0, f] = evaluate_form(joints, form + f, work.pose, work.forms[f, :4])
    if carried:
        work.forms[n - 1, :4] = 0
        read_profile(joints, form + n - 1, n, work.law[0], work.law[VALUES])
    compose(functions, joints.of[j, LAW + 2 * i], n, i, work)


@kernel
def change_spatial_number(joints, j, d, lam, levels, work):
    """Derivatives of a row and of its force by a number of its forms, see `change_row`."""
    kind, place, value, h = joints.design[d, 3], joints.design[d, 4], joints.design_value[d, 0], work.forms[MOST_FORMS]
    h[:4, :] = 0
    if of_profile(joints, j, d):
        change_profile(joints, j, d, carrier(joints, j, d), lam, levels, work)
        return
    if kind == CONSTANT:
        work.law[0, MOST_FORMS] = value
    elif kind == LINEAR:
        work.law[0, MOST_FORMS] = value * work.pose[0, joints.place[place]]
        h[0, joints.place[place]] = value
    else:
        work.law[0, MOST_FORMS] = add_product(joints.place[place], joints.place[place + 1], value, work.pose, h[:4])
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


@inlined
def direction_row(joints, j, i, side, y, rate, acceleration, centripetal, work):
    """Derivatives of one constraint row in one direction of one marker: of g_z (B a), of its rest at acceleration level, of g_z w, of g."""
    inertial, total, velocity, position = 0 * y[0], 0 * y[0], 0 * y[0], 0 * y[0]
    for e in range(joints.felt_start[ROWS * j + i], joints.felt_start[ROWS * j + i + 1]):
        if joints.felt[e] // 4 == side:
            for c in range(3):
                z, k = 3 * joints.felt[e] + c, 3 * (joints.felt[e] % 4) + c
                g, bent = work.slope[i, 0, z], work.slope[i, 1, z]
                inertial += g * acceleration[k] + work.slope[i, 2, z] * y[k]
                total += g * centripetal[k] + work.slope[i, 3, z] * y[k] + 2 * bent * rate[k]
                velocity += g * rate[k] + bent * y[k]
                position += g * y[k]
    return inertial, total, velocity, position


@inlined
def linear_row(joints, form, side, y, rate, acceleration, centripetal):
    """Derivatives of a constraint row without products, such as those of a ball joint, in one direction of one marker."""
    inertial, total, velocity, position = 0 * y[0], 0 * y[0], 0 * y[0], 0 * y[0]
    for e in range(joints.start[form, 0] + 1, joints.start[form, 1]):
        if joints.place[e] // 12 == side:
            g, k = joints.value[e], joints.place[e] % 12
            inertial += g * acceleration[k]
            total += g * centripetal[k]
            velocity += g * rate[k]
            position += g * y[k]
    return inertial, total, velocity, position


@inner
def spatial_joint_jacobian(joints, j, markers, state, levels, acc, work, parts, I_acc, I_q, A_q, A_v):
    """Derivatives of the residual by q, v, a and lam, scattered into the pattern; entries that are never anything have no place there.

    That by a coordinate's velocity is k_2 (g_z 2 B_v + 2 w^T g_zz B) + k_1 g_z B.
    """
    a, b = joints.of[j, 0], joints.of[j, 1]
    n_a = markers.start[a + 1] - markers.start[a]
    n = n_a + markers.start[b + 1] - markers.start[b]
    rows, k2, k1, k0, (by_a, by_q, by_s, by_v) = joints.of[j, N_ROWS], levels[0], levels[1], levels[2], parts
    position = joints.position[joints.of[j, POSITION] :]
    by_row, by_column = position[n * n :], position[n * n + rows * n :]
    form = joints.of[j, FORM]
    for i in range(rows):
        law, forms, lam = joints.of[j, LAW + 2 * i], joints.of[j, LAW + 1 + 2 * i], acc[joints.of[j, FIRST_ROW] + i]
        linear = law == PLAIN_LAW and joints.start[form, 1] == joints.start[form + 1, 0]
        for side in range(2):
            m = joints.of[j, side]
            for k in range(markers.start[m], markers.start[m + 1]):
                local = k - markers.start[m] + side * n_a
                at, transposed = by_row[i * n + local], by_column[local * rows + i]
                if at >= 0:
                    B, B_v, B_a, b_q = state.B[k], state.B_v[k], state.B_a[k], state.b_q[k]
                    if linear:
                        inertial, total, velocity, phi = linear_row(joints, form, side, B, B_v, B_a, b_q)
                    else:
                        inertial, total, velocity, phi = direction_row(joints, j, i, side, B, B_v, B_a, b_q, work)
                    I_acc[at] += by_a * k2 * phi
                    I_acc[transposed] += by_a * phi
                    I_q[at] += by_q * k2 * inertial
                    A_q[at] += by_s * (k2 * total + k1 * velocity + k0 * phi)
                    A_v[at] += by_v * (2 * k2 * velocity + k1 * phi)
        for f in range(forms):
            add_pairs(joints, j, form + f, by_q * lam * work.composed[i, f, 0], markers, state, position, n, n_a, I_q)
        form += forms
        if law != PLAIN_LAW:
            add_bend(joints, j, i, by_q * lam, markers, state, work, position, n, n_a, I_q)
    for side in range(2):
        force = work.force[0, 12 * side : 12 * side + 12]
        add_spatial_stiffness(markers, state, joints.of[j, side], force, by_q, position, n, side * n_a, I_q)


@inner
def add_pairs(joints, j, form, factor, markers, state, position, n, n_a, I_q):
    """Add factor B^T h_zz B of one form."""
    for e in range(joints.start[form, 1], joints.start[form + 1, 0], 2):
        value = factor * joints.value[e]
        side, other = joints.place[e] // 4, joints.place[e + 1] // 4
        at, to = 3 * (joints.place[e] % 4), 3 * (joints.place[e + 1] % 4)
        m, o = joints.of[j, side], joints.of[j, other]
        for k in range(markers.start[m], markers.start[m + 1]):
            row = k - markers.start[m] + side * n_a
            x, y, z = value * state.B[k, at], value * state.B[k, at + 1], value * state.B[k, at + 2]
            for c in range(markers.start[o], markers.start[o + 1]):
                column = c - markers.start[o] + other * n_a
                if position[row * n + column] >= 0:
                    entry = x * state.B[c, to] + y * state.B[c, to + 1] + z * state.B[c, to + 2]
                    I_q[position[row * n + column]] += entry
                    I_q[position[column * n + row]] += entry


@inner
def slope_along(i, f, side, y, work):
    """Derivative h_z y of one form of a law, for a direction y of one marker's pose."""
    slope = 0 * work.pose[0, 0]
    for c in range(12):
        slope += work.composed[i, f, GRADIENT + 12 * side + c] * y[c]
    return slope


@inner
def add_bend(joints, j, i, lam, markers, state, work, position, n, n_a, I_q):
    """Add lam B^T (sum of g_hh h_z h_z^T) B of a law."""
    forms = joints.of[j, LAW + 1 + 2 * i]
    for side in range(2):
        m = joints.of[j, side]
        for k in range(markers.start[m], markers.start[m + 1]):
            bent_slopes(i, forms, lam, side, state.B[k], work)
            slopes = work.law[1]
            row = k - markers.start[m] + side * n_a
            for other in range(2):
                o = joints.of[j, other]
                for c in range(markers.start[o], markers.start[o + 1]):
                    at, entry = position[row * n + c - markers.start[o] + other * n_a], 0 * work.pose[0, 0]
                    if at >= 0:
                        for f in range(forms):
                            entry += slopes[f] * slope_along(i, f, other, state.B[c], work)
                        I_q[at] += entry


@inner
def bent_slopes(i, forms, lam, side, y, work):
    """lam g_hh h_z y of a law, for a direction y of one marker's pose, in the place of its h'."""
    slopes = work.law[1]
    slopes[:] = 0
    for g in range(forms):
        slope = lam * slope_along(i, g, side, y, work)
        for f in range(forms):
            slopes[f] += work.composed[i, f, 5 + g] * slope


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
        if joints.of[j, LAW + 2 * i] != PLAIN_LAW:
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
