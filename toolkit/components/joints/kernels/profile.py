"""Rows that follow a curve of an angle: a cam's profile, by polynomials of its pieces over one turn.

    lift:    g = x - F(t)      of forms (x, c, s),             t = atan2(s, c)
    swing:   g = t_a - F(t)    of forms (c_a, s_a, c, s),      t_a = atan2(s_a, c_a),  g next to zero

The last form of such a row is none: it carries the numbers of F as its linear terms, for every piece the angle where it begins, its
middle m, and the coefficients of the powers of t - m. So every number of the curve reaches the row as those of all other forms do.
"""

import numpy as np

from toolkit.components.joints.kernels.laws import MOST_FORMS, PROFILE_LAW, add_angle, angle_of
from toolkit.components.joints.kernels.records import FORM, GRADIENT, LAW
from toolkit.foundation.kernel import inlined, inner, kernel

DEGREE = 9
"""Degree of the polynomials."""
PIECE = DEGREE + 3
"""Numbers of a piece."""
SEAM_OVERLAP = 1e-6
"""The angle 0, where motions start, is in the first piece whatever round-off makes of it: that begins so much earlier."""
VALUES = MOST_FORMS + 5
"""Row of `JointWork.law` with F, F', F'', F'''."""


@kernel
def profile_law(h, w, n, values, g, g_h, g_hh, g_hww):
    """Compute g and its derivatives for n forms, the last of which is none; F and its derivatives are in `values`."""
    at, slope, bend, change = n - 3, values[1], values[2], values[3]
    _, t_c, t_s, along_c, along_s = add_angle(h, w, at, -slope, g_h, g_hh, g_hww)
    rate = t_c * w[at] + t_s * w[at + 1]
    growth = along_c * w[at] + along_s * w[at + 1]
    for i in range(2):
        t_i, along_i = (t_c, along_c) if i == 0 else (t_s, along_s)
        for k in range(2):
            g_hh[at + i, at + k] -= bend * t_i * (t_c if k == 0 else t_s)
        g_hww[at + i] -= change * t_i * rate * rate + bend * (2 * rate * along_i + t_i * growth)
    if at == 1:
        g[0] = h[0] - values[0]
        g_h[0] = 1
    else:
        found = add_angle(h, w, 0, 1.0, g_h, g_hh, g_hww)
        g[0] = found[0] - values[0]
        g[0] -= 2 * np.pi * np.rint(g[0].real / (2 * np.pi))


@inner
def piece_of(joints, form, angle):
    """Place of the piece of a profile that an angle of one turn is in."""
    first, last = joints.start[form, 0] + 1, joints.start[form, 1]
    at = first
    for k in range(first + PIECE, last, PIECE):
        if joints.value[k].real <= angle.real:
            at = k
    return at


@inlined
def whole_angle(h, n):
    """Angle t of one turn, from just below zero on."""
    angle = angle_of(h[n - 2], h[n - 3])
    return angle + 2 * np.pi if angle.real < -SEAM_OVERLAP else angle


@inner
def read_profile(joints, form, n, h, values):
    """Compute F, F', F'', F''' at the angle of a row of n forms, the last of which is given."""
    angle = whole_angle(h, n)
    at = piece_of(joints, form, angle)
    x = angle - joints.value[at + 1]
    a, b, c, d = 0 * x, 0 * x, 0 * x, 0 * x
    for k in range(PIECE - 1, 1, -1):
        d = d * x + c
        c = c * x + b
        b = b * x + a
        a = a * x + joints.value[at + k]
    values[0], values[1], values[2], values[3] = a, b, 2 * c, 6 * d


@inlined
def of_profile(joints, j, d):
    """Whether a number that the design changes is one of a profile."""
    i = joints.design[d, 1]
    return joints.of[j, LAW + 2 * i] == PROFILE_LAW and joints.design[d, 2] == joints.of[j, LAW + 1 + 2 * i] - 1


@inner
def carrier(joints, j, d):
    """Number of the form that carries the profile of such a number."""
    form = joints.of[j, FORM] + joints.design[d, 2]
    for i in range(joints.design[d, 1]):
        form += joints.of[j, LAW + 1 + 2 * i]
    return form


@inner
def change_profile(joints, j, d, form, lam, levels, work):
    """Derivatives of a row and of its force by a number of its profile, left where `change_row` leaves them."""
    i, n, value = joints.design[d, 1], joints.design[d, 2] + 1, joints.design_value[d, 0]
    work.row[0, i], work.row[1, i] = 0, 0
    work.force[1] = 0
    h, angle = work.law[0], whole_angle(work.law[0], n)
    at = piece_of(joints, form, angle)
    k = joints.design[d, 4] - at
    if k < 1 or k >= PIECE:
        return
    x = angle - joints.value[at + 1]
    if k == 1:  # the middle
        change, slope, bend = -value * work.law[VALUES, 1], -value * work.law[VALUES, 2], -value * work.law[VALUES, 3]
    else:
        p = k - 2
        change = value * x**p
        slope = value * p * x ** (p - 1) if p > 0 else 0 * change
        bend = value * p * (p - 1) * x ** (p - 2) if p > 1 else 0 * change
    c, s = h[n - 3], h[n - 2]
    square = c * c + s * s
    t_c, t_s, t_cc, t_cs = -s / square, c / square, 2 * s * c / square**2, (s * s - c * c) / square**2
    of_c, of_s = work.composed[i, n - 3], work.composed[i, n - 2]
    rate, acceleration = t_c * of_c[2] + t_s * of_s[2], t_c * of_c[3] + t_s * of_s[3]
    total = t_c * of_c[4] + t_s * of_s[4] + t_cc * (of_c[2] ** 2 - of_s[2] ** 2) + 2 * t_cs * of_c[2] * of_s[2]
    work.row[0, i] = -levels[0] * slope * acceleration
    work.row[1, i] = -levels[0] * (slope * total + bend * rate * rate) - levels[1] * slope * rate - levels[2] * change
    for c in range(work.force.shape[1]):
        work.force[1, c] = -lam * slope * (t_c * of_c[GRADIENT + c] + t_s * of_s[GRADIENT + c])
