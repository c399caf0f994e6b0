"""All spatial joints in the compiled loop: quadratic forms of the poses of two markers, at acceleration level and stabilized.

A pose is four vectors (position and axes, see `bodies.spatial.marker_kernel`); z holds those of markers a and b, X_0 ... X_7.
Every row of a joint is a form, or the angle of two forms:

    form:    h(z) = constant + sum linear * (component of X_i) + sum value * X_i . X_j
    row:     g = h,      or      g = atan2(h_2, h_1), an angle that is taken next to the curve it follows

So g_zz of a form is constant and its third derivative zero; the chain rule of atan2 gives those of an angle. Rows of the residual are those
of planar joints (see `joints.joint_kernel`), with g_z, g_zz and d(w^T g_zz w)/dz from here.
"""

from typing import NamedTuple

import numpy as np

from toolkit.foundation.kernel import inlined, inner, kernel
from toolkit.markers.spatial.marker_forces import add_spatial_force

ROWS, NUMBERS = 6, 24
"""Most rows of a joint, and numbers of two poses."""


class SpatialJoints(NamedTuple):
    """What never changes."""

    marker: np.ndarray  # (n_j, 2)
    row: np.ndarray  # (n_j,) number of its first multiplier among all unknowns
    n_rows: np.ndarray  # (n_j,)
    curve: np.ndarray  # (n_j,) time curve that its last row follows, or -1
    designed: np.ndarray  # (n_j,) 1 if any design variable matters to it
    first_form: np.ndarray  # (n_j,) forms of its rows follow each other; an angle has two
    is_angle: np.ndarray  # (n_j, ROWS)
    constant: np.ndarray  # (n_forms,)
    linear_start: np.ndarray  # (n_forms + 1,) into the next two
    linear_place: np.ndarray  # which of the 24 numbers
    linear_value: np.ndarray
    pair_start: np.ndarray  # (n_forms + 1,) into the next two
    pair: np.ndarray  # (n_pairs, 2) which vectors
    pair_value: np.ndarray
    block_start: np.ndarray  # (n_j * ROWS + 1,) into the next
    block: np.ndarray  # vectors that a row feels
    design_start: np.ndarray  # (n_j + 1,) into the next four
    design_variable: np.ndarray
    design_row: np.ndarray  # row of the joint, a plain one
    design_kind: np.ndarray  # 0: the constant, 1: a linear term, 2: a pair
    design_place: np.ndarray  # which linear term or pair
    design_value: np.ndarray  # derivative of its value
    position_start: np.ndarray  # (n_j,) into the next
    position: np.ndarray  # where local entries are stored: coordinates x coordinates, rows x coordinates, transposed

    def work(self, dtype: type) -> "SpatialJointWork":
        """Memory for any joint."""
        row, numbers = (ROWS,), (ROWS, NUMBERS)
        shapes = [(NUMBERS,)] * 4 + [row, numbers, (ROWS, 3, NUMBERS)] + [(2,), (2, NUMBERS), (2, 3, NUMBERS), (2, 3)]
        shapes += [(ROWS, 2), (ROWS, 3), (ROWS, 2, NUMBERS), (NUMBERS,), (NUMBERS,), (4, ROWS)]
        return SpatialJointWork(*(np.zeros(shape, dtype) for shape in shapes))


class SpatialJointWork(NamedTuple):
    """Scratch memory for one joint."""

    z: np.ndarray  # (24,) both poses
    w: np.ndarray  # their rates, B v
    acceleration: np.ndarray  # B a
    centripetal: np.ndarray  # b
    phi: np.ndarray  # (ROWS,) g
    phi_z: np.ndarray  # (ROWS, 24)
    along: np.ndarray  # (ROWS, 3, 24): g_zz w, g_zz (B a), g_zz b + d(w g_zz w)/dz
    h: np.ndarray  # (2,) forms of one row
    h_z: np.ndarray  # (2, 24)
    h_along: np.ndarray  # (2, 3, 24): h_zz w, h_zz (B a), h_zz b
    h_rate: np.ndarray  # (2, 3): h_z w, h_z (B a), w h_zz w
    slope: np.ndarray  # (ROWS, 2) dg/dh
    bend: np.ndarray  # (ROWS, 3) second derivatives of an angle by its forms: 11, 12, 22
    angle_z: np.ndarray  # (ROWS, 2, 24) h_z of the forms of angles
    force: np.ndarray  # (24,) g_z^T lam
    dforce: np.ndarray  # (24,)
    row: np.ndarray  # (4, ROWS) of one direction: d inertial, d applied, d applied by its rate, g_z y


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
def evaluate_form(joints, form, which, work):
    """One form with its derivatives, as number `which` of its row."""
    h_z, along = work.h_z[which], work.h_along[which]
    h_z[:] = 0
    along[:] = 0
    value = joints.constant[form] + 0 * work.z[0]
    for e in range(joints.linear_start[form], joints.linear_start[form + 1]):
        value += joints.linear_value[e] * work.z[joints.linear_place[e]]
        h_z[joints.linear_place[e]] += joints.linear_value[e]
    for e in range(joints.pair_start[form], joints.pair_start[form + 1]):
        i, j, factor = joints.pair[e, 0], joints.pair[e, 1], joints.pair_value[e]
        value += factor * dot_pair(work.z, i, work.z, j)
        add_pair(factor, i, j, work.z, h_z)
        add_pair(factor, i, j, work.w, along[0])
        add_pair(factor, i, j, work.acceleration, along[1])
        add_pair(factor, i, j, work.centripetal, along[2])
    work.h[which] = value
    for k in range(3):
        work.h_rate[which, k] = 0
    for k in range(NUMBERS):
        work.h_rate[which, 0] += h_z[k] * work.w[k]
        work.h_rate[which, 1] += h_z[k] * work.acceleration[k]
        work.h_rate[which, 2] += along[0, k] * work.w[k]


@inlined
def compose_plain(i, work):
    """A row that is a form."""
    work.phi[i], work.slope[i, 0], work.slope[i, 1] = work.h[0], 1, 0
    for k in range(3):
        work.bend[i, k] = 0
    for k in range(NUMBERS):
        work.phi_z[i, k] = work.h_z[0, k]
        for direction in range(3):
            work.along[i, direction, k] = work.h_along[0, direction, k]


@inner
def angle_of(sine, cosine):
    """atan2 that also takes complex numbers with small imaginary parts."""
    turn = np.arctan2(sine.real, cosine.real)
    across = (sine * np.cos(turn) - cosine * np.sin(turn)) / (cosine * np.cos(turn) + sine * np.sin(turn))
    return turn + across


@inner
def compose_angle(i, work):
    """A row g = atan2(h_2, h_1), with s = h_2, c = h_1."""
    c, s = work.h[0], work.h[1]
    square = c * c + s * s
    g_c, g_s = -s / square, c / square
    g_cc, g_cs, g_ss = 2 * s * c / square**2, (s * s - c * c) / square**2, -2 * s * c / square**2
    cube = square**3
    g_ccc, g_ccs = 2 * s * (s * s - 3 * c * c) / cube, 2 * c * (c * c - 3 * s * s) / cube
    g_css, g_sss = -g_ccc, -g_ccs
    work.phi[i], work.slope[i, 0], work.slope[i, 1] = angle_of(s, c), g_c, g_s
    work.bend[i, 0], work.bend[i, 1], work.bend[i, 2] = g_cc, g_cs, g_ss
    c_w, c_a, c_ww = work.h_rate[0]
    s_w, s_a, s_ww = work.h_rate[1]
    c_b, s_b = 0 * c, 0 * c
    for k in range(NUMBERS):
        c_b += work.h_z[0, k] * work.centripetal[k]
        s_b += work.h_z[1, k] * work.centripetal[k]
    in_c = g_ccc * c_w * c_w + 2 * g_ccs * c_w * s_w + g_css * s_w * s_w + g_cc * (c_ww + c_b) + g_cs * (s_ww + s_b)
    in_s = g_ccs * c_w * c_w + 2 * g_css * c_w * s_w + g_sss * s_w * s_w + g_cs * (c_ww + c_b) + g_ss * (s_ww + s_b)
    c_rate, s_rate = g_cc * c_w + g_cs * s_w, g_cs * c_w + g_ss * s_w
    for k in range(NUMBERS):
        c_z, s_z = work.h_z[0, k], work.h_z[1, k]
        work.angle_z[i, 0, k], work.angle_z[i, 1, k] = c_z, s_z
        work.phi_z[i, k] = g_c * c_z + g_s * s_z
        for direction in range(3):
            work.along[i, direction, k] = g_c * work.h_along[0, direction, k] + g_s * work.h_along[1, direction, k]
        work.along[i, 0, k] += c_rate * c_z + s_rate * s_z
        work.along[i, 1, k] += (g_cc * c_a + g_cs * s_a) * c_z + (g_cs * c_a + g_ss * s_a) * s_z
        work.along[i, 2, k] += in_c * c_z + in_s * s_z
        work.along[i, 2, k] += 2 * (c_rate * work.h_along[0, 0, k] + s_rate * work.h_along[1, 0, k])


@kernel
def evaluate_spatial_joint(joints, j, state, acc, work):
    """All rows of one joint with their derivatives at the poses of the two markers, and its force g_z^T lam."""
    for side in range(2):
        m = joints.marker[j, side]
        for k in range(12):
            at = 12 * side + k
            work.z[at], work.w[at] = state.y[m, k], state.rate[m, k]
            work.acceleration[at], work.centripetal[at] = state.acceleration[m, k], state.centripetal[m, k]
    form = joints.first_form[j]
    work.force[:] = 0
    for i in range(joints.n_rows[j]):
        evaluate_form(joints, form, 0, work)
        form += 1
        if joints.is_angle[j, i] == 1:
            evaluate_form(joints, form, 1, work)
            form += 1
            compose_angle(i, work)
        else:
            compose_plain(i, work)
        for k in range(NUMBERS):
            work.force[k] += work.phi_z[i, k] * acc[joints.row[j] + i]


@inlined
def gap(joints, j, i, value, target):
    """value - target; of an angle that of the turn next to the target."""
    difference = value - target
    if joints.is_angle[j, i] == 1:
        difference -= 2 * np.pi * np.round(difference.real / (2 * np.pi))
    return difference


@inner
def spatial_joint_residual(joints, j, markers, state, curves, levels, work, inertial, applied):
    """Constraint rows, and constraint forces on both bodies."""
    k2, k1, k0 = levels[0], levels[1], levels[2]
    for i in range(joints.n_rows[j]):
        growth, total, rate, target = 0 * work.z[0], 0 * work.z[0], 0 * work.z[0], 0 * work.z[0]
        for k in range(NUMBERS):
            growth += work.phi_z[i, k] * work.acceleration[k]
            total += work.phi_z[i, k] * work.centripetal[k] + work.along[i, 0, k] * work.w[k]
            rate += work.phi_z[i, k] * work.w[k]
        row = joints.row[j] + i
        if joints.curve[j] >= 0 and i == joints.n_rows[j] - 1:
            f = curves[joints.curve[j]]
            target, rate, total = target + f[0], rate - f[1], total - f[2]
        inertial[row] += k2 * growth
        applied[row] += k2 * total + k1 * rate + k0 * gap(joints, j, i, work.phi[i], target)
    add_spatial_force(markers, state, joints.marker[j, 0], work.force[:12], 1.0, inertial)
    add_spatial_force(markers, state, joints.marker[j, 1], work.force[12:], 1.0, inertial)
