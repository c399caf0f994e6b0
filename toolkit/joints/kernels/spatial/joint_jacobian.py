"""Spatial joints in the compiled loop: derivatives of their rows and forces by the state, direction by direction.

A direction is a coordinate or a design variable of one marker, given by its derivatives of y, B v, B a and b (see `joint_kernel`).
"""

from toolkit.foundation.kernel import inlined, inner
from toolkit.joints.kernels.laws import PLAIN
from toolkit.joints.kernels.records import FIRST_ROW, FORM, GRADIENT, LAW, N_ROWS, POSITION
from toolkit.joints.kernels.records import SPATIAL_ROWS as ROWS
from toolkit.markers.spatial.marker_forces import add_spatial_stiffness


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
        linear = law == PLAIN and joints.start[form, 1] == joints.start[form + 1, 0]
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
        if law != PLAIN:
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
