"""Open formulas: rows of joints in the plane and in space that are no forms, but functions of a few of them.

A law g(h) takes the values of its row's forms, h, and their rates, w = h', and fills g and the derivatives g_h, g_hh and
d(w^T g_hh w)/dh. The chain rule through the forms is that of all joints, see `composition`.

Those of a screw, a rack and of gear wheels couple turns: with a length, and with each other. An angle is that of a vector (c, s),
t = atan2(s, c), with

    t_c = -s / d,  t_s = c / d,  t_cc = -t_ss = 2 s c / d^2,  t_cs = (s^2 - c^2) / d^2,      d = c^2 + s^2

A vector does not say how often it has turned. `turn_law` and `teeth_law` take the number of turns with which they are next to zero, so that
angles of any number of turns are meant as long as a step moves them by less than half of what one turn more or less would change.
"""

import numba
import numpy as np

from toolkit.foundation.kernel import inner, kernel

MOST_FORMS = 6
"""Most forms of a law."""
PROFILE_LAW, PLAIN_LAW, ANGLE_LAW = -3, -2, -1
"""Numbers in the place of a law's: a curve of an angle (see `profile`), a row that is a form, and an angle. They are no functions
of their own in the loop."""

_f8 = numba.float64
SIGNATURE = numba.void(_f8[::1], _f8[::1], _f8[::1], _f8[::1], _f8[:, ::1], _f8[::1])
"""law(h, w, g, g_h, g_hh, g_hww); the last four are zero on entry and are filled, g in its only entry."""


@inner
def angle_of(sine, cosine):
    """Angle atan2(s, c), also of complex numbers with small imaginary parts."""
    turn = np.arctan2(sine.real, cosine.real)
    across = (sine * np.cos(turn) - cosine * np.sin(turn)) / (cosine * np.cos(turn) + sine * np.sin(turn))
    return turn + across


@kernel
def angle_law(h, w, g, g_h, g_hh, g_hww):
    """g = atan2(s, c), c = h_0, s = h_1."""
    c, s = h[0], h[1]
    square = c * c + s * s
    g_cc, g_cs = 2 * s * c / square**2, (s * s - c * c) / square**2
    cube = square**3
    g_ccc, g_ccs = 2 * s * (s * s - 3 * c * c) / cube, 2 * c * (c * c - 3 * s * s) / cube
    g[0] = angle_of(s, c)
    g_h[0], g_h[1] = -s / square, c / square
    g_hh[0, 0], g_hh[0, 1], g_hh[1, 0], g_hh[1, 1] = g_cc, g_cs, g_cs, -g_cc
    g_hww[0] = g_ccc * w[0] * w[0] + 2 * g_ccs * w[0] * w[1] - g_ccc * w[1] * w[1]
    g_hww[1] = g_ccs * w[0] * w[0] - 2 * g_ccc * w[0] * w[1] - g_ccs * w[1] * w[1]


@inner
def add_angle(h, w, at, factor, g_h, g_hh, g_hww):
    """Add the derivatives of factor t of the vector (h[at], h[at + 1]); returns t, both numbers of t_z, and both of t_zz w."""
    c, s, u, v = h[at], h[at + 1], w[at], w[at + 1]
    square = c * c + s * s
    t_c, t_s, t_cc, t_cs = -s / square, c / square, 2 * s * c / square**2, (s * s - c * c) / square**2
    t_ccc, t_ccs = 2 * s * (s * s - 3 * c * c) / square**3, 2 * c * (c * c - 3 * s * s) / square**3
    g_h[at], g_h[at + 1] = factor * t_c, factor * t_s
    g_hh[at, at], g_hh[at, at + 1], g_hh[at + 1, at], g_hh[at + 1, at + 1] = (
        factor * t_cc,
        factor * t_cs,
        factor * t_cs,
        -factor * t_cc,
    )
    g_hww[at] = factor * (t_ccc * u * u + 2 * t_ccs * u * v - t_ccc * v * v)
    g_hww[at + 1] = factor * (t_ccs * u * u - 2 * t_ccc * u * v - t_ccs * v * v)
    return angle_of(s, c), t_c, t_s, t_cc * u + t_cs * v, t_cs * u - t_cc * v


@inner
def scale_angle(w, at, by, sign, found, g_h, g_hh, g_hww):
    """Add the derivatives that a factor h[by], times a sign, brings to an angle whose derivatives are `found`; not g_h[by]."""
    _, t_c, t_s, along_c, along_s = found
    g_hh[at, by] = g_hh[by, at] = sign * t_c
    g_hh[at + 1, by] = g_hh[by, at + 1] = sign * t_s
    g_hww[at] += 2 * sign * w[by] * along_c
    g_hww[at + 1] += 2 * sign * w[by] * along_s
    g_hww[by] += sign * (w[at] * along_c + w[at + 1] * along_s)


@kernel
def turn_law(h, w, g, g_h, g_hh, g_hww):
    """g = x - p t of h = (x, c, s, p), t = atan2(s, c) of the turn next to x / p; where p is zero t does not matter."""
    x, p = h[0], h[3]
    found = add_angle(h, w, 1, -p, g_h, g_hh, g_hww)
    scale_angle(w, 1, 3, -1.0, found, g_h, g_hh, g_hww)
    turn = found[0]
    if p.real != 0:
        turn += 2 * np.pi * np.rint((x / p - turn).real / (2 * np.pi))
    g[0] = x - p * turn
    g_h[0], g_h[3] = 1, -turn


@kernel
def teeth_law(h, w, g, g_h, g_hh, g_hww):
    """g = t_a + n t_b + k d of h = (c_a, s_a, c_b, s_b, n, d), with the whole number k with which it is next to zero.

    n and d are whole numbers of teeth over each other and a turn over one of them, which no design moves.
    """
    of_a = add_angle(h, w, 0, 1.0, g_h, g_hh, g_hww)
    of_b = add_angle(h, w, 2, h[4], g_h, g_hh, g_hww)
    g[0] = of_a[0] + h[4] * of_b[0]
    g[0] -= h[5] * np.rint((g[0] / h[5]).real)
