"""Quantities g(z) of two poses that loads measure between their markers, and act along, in the plane and in space.

Each function returns g, and fills its derivatives g_z into `slope` (n,) and g_zz into the first n columns of `bend`; z is that of
`load_kernel`.
"""

import numpy as np

from toolkit.components.joints.kernels.laws import angle_of
from toolkit.foundation.kernel import inner

AXIS_ANGLE = 10
"""Place in z of the angle of an axis in the plane: the last parameter."""


@inner
def plane_angle(z, slope, bend):
    """g = angle_a - angle_b, of any number of turns."""
    slope[2], slope[5] = 1, -1
    return z[2] - z[5]


@inner
def plane_offset(z, slope, bend):
    """g = e . (r_a - r_b), e = (cos, sin) of angle_b + z[AXIS_ANGLE]: the axis is fixed in body b."""
    c, s, x, y = np.cos(z[5] + z[AXIS_ANGLE]), np.sin(z[5] + z[AXIS_ANGLE]), z[0] - z[3], z[1] - z[4]
    offset = c * x + s * y
    slope[0], slope[1], slope[3], slope[4], slope[5] = c, s, -c, -s, c * y - s * x
    bend[0, 5], bend[1, 5], bend[3, 5], bend[4, 5], bend[5, 5] = -s, c, s, -c, -offset
    for i in range(5):
        bend[5, i] = bend[i, 5]
    return offset


@inner
def space_offset(z, slope, bend):
    """g = e_3b . (r_a - r_b)."""
    offset = 0 * z[0]
    for i in range(3):
        d = z[i] - z[12 + i]
        slope[i], slope[12 + i], slope[21 + i] = z[21 + i], -z[21 + i], d
        bend[i, 21 + i], bend[21 + i, i], bend[12 + i, 21 + i], bend[21 + i, 12 + i] = 1, 1, -1, -1
        offset += z[21 + i] * d
    return offset


@inner
def distance(z, size, slope, bend):
    """g = |r_a - r_b|, with the second pose from z[size] on: 3 in the plane, 12 in space."""
    axes, square = 2 if size == 3 else 3, 0 * z[0]
    for i in range(axes):
        square += (z[i] - z[size + i]) * (z[i] - z[size + i])
    length = np.sqrt(square)
    for i in range(axes):
        slope[i] = (z[i] - z[size + i]) / length
        slope[size + i] = -slope[i]
    for i in range(axes):
        for j in range(axes):
            entry = ((1 if i == j else 0) - slope[i] * slope[j]) / length
            bend[i, j], bend[size + i, size + j] = entry, entry
            bend[i, size + j], bend[size + i, j] = -entry, -entry
    return length


@inner
def space_angle(z, slope, bend):
    """g = atan2(s, c), s = e_1a . e_2b, c = e_1a . e_1b: the rotation about the third axis, in (-pi, pi].

    g_zz = g_c c_zz + g_s s_zz + g_cc (c_z c_z - s_z s_z) + g_cs (c_z s_z + s_z c_z)
    """
    cosine, sine = 0 * z[0], 0 * z[0]
    for i in range(3, 6):
        cosine += z[i] * z[12 + i]
        sine += z[i] * z[15 + i]
    square = cosine * cosine + sine * sine
    g_c, g_s = -sine / square, cosine / square
    g_cc, g_cs = -2 * g_c * g_s, g_c * g_c - g_s * g_s
    for k in range(9):
        slope[felt(k)] = g_c * by_cosine(k, z) + g_s * by_sine(k, z)
        for m in range(9):
            c_k, s_k, c_m, s_m = by_cosine(k, z), by_sine(k, z), by_cosine(m, z), by_sine(m, z)
            bend[felt(k), felt(m)] = g_cc * (c_k * c_m - s_k * s_m) + g_cs * (c_k * s_m + s_k * c_m)
    for i in range(3, 6):
        bend[i, 12 + i] += g_c
        bend[12 + i, i] += g_c
        bend[i, 15 + i] += g_s
        bend[15 + i, i] += g_s
    return angle_of(sine, cosine)


@inner
def turn_next_to(near, angle):
    """Angle with as many whole turns more as bring it next to another one."""
    return angle + 2 * np.pi * np.rint((near - angle).real / (2 * np.pi))


@inner
def felt(k):
    """Place in z of number k of e_1a, e_1b, e_2b."""
    return 3 + k if k < 3 else 12 + k


@inner
def by_cosine(k, z):
    """Derivative of the cosine e_1a . e_1b by a number of these axes."""
    return z[15 + k] if k < 3 else z[k] if k < 6 else 0 * z[0]


@inner
def by_sine(k, z):
    """Derivative of the sine e_1a . e_2b by a number of these axes."""
    return z[18 + k] if k < 3 else 0 * z[0] if k < 6 else z[k - 3]
