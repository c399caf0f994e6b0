"""Open formulas: rows of joints in the plane and in space that are no forms, but functions of a few of them.

A law g(h) takes the values of its row's forms, h, and their rates, w = h', and fills g and the derivatives g_h, g_hh and
d(w^T g_hh w)/dh. The chain rule through the forms is that of all joints, see `composition`.
"""

import numba
import numpy as np

from toolkit.foundation.kernel import inner, kernel

FORMS = 6
"""Most forms of a law."""
PROFILE, PLAIN, ANGLE = -3, -2, -1
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
