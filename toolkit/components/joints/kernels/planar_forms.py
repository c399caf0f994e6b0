"""Forms of the poses of two markers in the plane, with their derivatives.

    h(z) = constant + sum value * z_k + pairs,       A_k = A(angle_k), X_k the position (z_k, z_k+1)

    pair (i, k)      i = 6, k = 6:              p d . d,  d = X_0 - X_3
                     i = 6, k = 2 or 5:         d . A_k (p, q)
                     i = 0 or 3, k = 0 or 3:    p X_i . X_k
                     i = 0 or 3, k = 2 or 5:    X_i . A_k (p, q)
                     i = 2 or 5, k = 2 or 5:    p cos(z_i - z_k) + q sin(z_i - z_k)

Without pairs a form has first derivatives only.
"""

from toolkit.foundation.kernel import inlined


@inlined
def add_pair(i, k, p, q, pose, h_z, h_zz, h_zww):
    """Value of one product of vectors; its derivatives are added."""
    if i == 6:
        return add_square(p, pose[0], h_z, h_zz) if k == 6 else add_slide(k, p, q, pose, h_z, h_zz, h_zww)
    if k % 3 == 0:
        return add_positions(i, k, p, pose[0], h_z, h_zz)
    if i % 3 == 0:
        return add_offset(i, k, p, q, pose, h_z, h_zz, h_zww)
    return add_turn(i, k, p, q, pose, h_z, h_zz, h_zww)


@inlined
def add_square(p, z, h_z, h_zz):
    """Value of the product p d . d; its derivatives are added."""
    total = 0 * z[0]
    for c in range(2):
        d = z[c] - z[3 + c]
        h_z[c] += 2 * p * d
        h_z[3 + c] -= 2 * p * d
        h_zz[c, c] += 2 * p
        h_zz[3 + c, 3 + c] += 2 * p
        h_zz[c, 3 + c] -= 2 * p
        h_zz[3 + c, c] -= 2 * p
        total += p * d * d
    return total


@inlined
def add_slide(k, p, q, pose, h_z, h_zz, h_zww):
    """Value of the product d . e; its derivatives are added, see `add_offset`."""
    of, x, y = 2 * (k // 3), pose[0, 0] - pose[0, 3], pose[0, 1] - pose[0, 4]
    c, s = pose[4, of], pose[4, of + 1]
    e_x, e_y, w = c * p - s * q, s * p + c * q, pose[1, k]
    along, across = x * e_x + y * e_y, y * e_x - x * e_y
    for i in (0, 3):
        sign = 1 - 2 * (i // 3)
        h_z[i] += sign * e_x
        h_z[i + 1] += sign * e_y
        h_zz[i, k] -= sign * e_y
        h_zz[k, i] -= sign * e_y
        h_zz[i + 1, k] += sign * e_x
        h_zz[k, i + 1] += sign * e_x
        h_zww[i] -= sign * e_x * w * w
        h_zww[i + 1] -= sign * e_y * w * w
    h_z[k] += across
    h_zz[k, k] -= along
    h_zww[k] -= (2 * ((pose[1, 0] - pose[1, 3]) * e_x + (pose[1, 1] - pose[1, 4]) * e_y) + across * w) * w
    return along


@inlined
def add_positions(i, k, p, z, h_z, h_zz):
    """Value of the product p X_i . X_k; its derivatives are added."""
    for c in range(2):
        h_z[i + c] += p * z[k + c]
        h_z[k + c] += p * z[i + c]
        h_zz[i + c, k + c] += p
        h_zz[k + c, i + c] += p
    return p * (z[i] * z[k] + z[i + 1] * z[k + 1])


@inlined
def add_offset(i, k, p, q, pose, h_z, h_zz, h_zww):
    """Value of X_i . e with e = A_k (p, q), e' = J e, e'' = -e, J = [[0,-1],[1,0]]; its derivatives are added."""
    of, x, y = 2 * (k // 3), pose[0, i], pose[0, i + 1]
    c, s = pose[4, of], pose[4, of + 1]
    e_x, e_y, w = c * p - s * q, s * p + c * q, pose[1, k]
    along, across = x * e_x + y * e_y, y * e_x - x * e_y
    h_z[i] += e_x
    h_z[i + 1] += e_y
    h_z[k] += across
    h_zz[i, k] -= e_y
    h_zz[k, i] -= e_y
    h_zz[i + 1, k] += e_x
    h_zz[k, i + 1] += e_x
    h_zz[k, k] -= along
    h_zww[i] -= e_x * w * w
    h_zww[i + 1] -= e_y * w * w
    h_zww[k] -= (2 * (pose[1, i] * e_x + pose[1, i + 1] * e_y) + across * w) * w
    return along


@inlined
def add_turn(i, k, p, q, pose, h_z, h_zz, h_zww):
    """Value of p cos + q sin of z_i - z_k; its derivatives are added."""
    of, of_k = 2 * (i // 3), 2 * (k // 3)
    c, s, c_k, s_k = pose[4, of], pose[4, of + 1], pose[4, of_k], pose[4, of_k + 1]
    c, s = c * c_k + s * s_k, s * c_k - c * s_k
    value, slope, w = p * c + q * s, q * c - p * s, pose[1, i] - pose[1, k]
    h_z[i] += slope
    h_z[k] -= slope
    h_zz[i, i] -= value
    h_zz[k, k] -= value
    h_zz[i, k] += value
    h_zz[k, i] += value
    h_zww[i] -= slope * w * w
    h_zww[k] += slope * w * w
    return value


@inlined
def evaluate_form(joints, form, pose, slope, h_zz, h_zww):
    """Value of one form; its derivatives are filled, without pairs only the first ones."""
    h_z = slope[0]
    for k in range(6):
        h_z[k] = 0
    first, pairs, last = joints.start[form, 0], joints.start[form, 1], joints.start[form + 1, 0]
    total = joints.value[first] + 0 * pose[0, 0]
    for e in range(first + 1, pairs):
        total += joints.value[e] * pose[0, joints.place[e]]
        h_z[joints.place[e]] += joints.value[e]
    if pairs < last:
        h_zz[:, :] = 0
        h_zww[:] = 0
        for e in range(pairs, last, 2):
            p, q = joints.value[e], joints.value[e + 1]
            total += add_pair(joints.place[e], joints.place[e + 1], p, q, pose, h_z, h_zz, h_zww)
        contract(pose, h_zz, h_zww, slope)
    return total


@inlined
def contract(pose, h_zz, h_zww, slope):
    """Compute the products of h_zz that all directions share."""
    for k in range(6):
        rates, accelerations, centripetal = 0 * h_zww[k], 0 * h_zww[k], h_zww[k]
        for c in range(6):
            rates += h_zz[k, c] * pose[1, c]
            accelerations += h_zz[k, c] * pose[2, c]
            centripetal += h_zz[k, c] * pose[3, c]
        slope[1, k], slope[2, k], slope[3, k] = rates, accelerations, centripetal
