"""Rotation of a node that an elastic deformation turns by the rotation vector phi, and its derivatives up to the third order.

    R(phi) e = e + s_1(x) phi x e + s_2(x) phi x (phi x e),    x = phi . phi,    s_1 = sin(|phi|) / |phi|,   s_2 = (1 - cos |phi|) / x

s_1 and s_2 are entire functions of x, so their series serve everywhere: without a branch at zero, and for complex numbers too.
"""

from math import factorial, perm
from typing import NamedTuple

import numpy as np

from toolkit.foundation.kernel import inner

SERIES_TERMS = 20
"""Number of terms of the series: they leave round-off up to a full turn."""


def _series() -> np.ndarray:
    """Coefficients of s_1 and s_2 and of their first three derivatives by x, (2, 4, SERIES_TERMS)."""
    found = np.zeros((2, 4, SERIES_TERMS))
    for which in range(2):
        for order in range(4):
            for n in range(order, SERIES_TERMS + order):
                found[which, order, n - order] = (-1) ** n * perm(n, order) / factorial(2 * n + 1 + which)
    return found


SERIES = _series()


class TurnedVector(NamedTuple):
    """R e and its derivatives by phi, contracted with phi' and phi''; the rows count components of phi."""

    value: np.ndarray  # (3,) R e
    by: np.ndarray  # (3, 3) D_i
    by_by: np.ndarray  # (3, 3, 3) D_il
    along_rate: np.ndarray  # (3, 3) D_il phi_l'
    along_growth: np.ndarray  # (3, 3) D_il phi_l''
    curved: np.ndarray  # (3, 3) D_iln phi_l' phi_n'


def turned_vector(dtype: type) -> TurnedVector:
    """Scratch memory for one turned vector and its derivatives."""
    return TurnedVector(*(np.zeros(shape, dtype) for shape in ((3,), (3, 3), (3, 3, 3), (3, 3), (3, 3), (3, 3))))


@inner
def series(which, order, x):
    """s_1 (which = 0) or s_2 (1), differentiated by x."""
    total = 0 * x
    for n in range(SERIES_TERMS - 1, -1, -1):
        total = total * x + SERIES[which, order, n]
    return total


@inner
def dot(a, b):
    """Scalar product of two vectors, without the conjugate."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inner
def unit_cross(i, e, c):
    """Component c of e_i x e."""
    if c == i:
        return 0 * e[0]
    return e[3 - i - c] if (c - i) % 3 == 2 else -e[3 - i - c]


@inner
def turn(phi, rate, growth, e, out):
    """Compute R e and all its derivatives."""
    x, along, step, square = dot(phi, phi), dot(phi, e), dot(phi, rate), dot(rate, rate)
    for c in range(3):
        out.value[c] = e[c]
    for array in (out.by, out.along_rate, out.along_growth, out.curved):
        array[:] = 0
    out.by_by[:] = 0
    for which in range(2):
        s, s1, s2, s3 = series(which, 0, x), series(which, 1, x), series(which, 2, x), series(which, 3, x)
        s_h, s_hh = 2 * s1 * step, 4 * s2 * step * step + 2 * s1 * square
        for c in range(3):
            P, P_h, P_hh = form(which, phi, rate, e, x, along, step, square, c)
            out.value[c] += s * P
            for i in range(3):
                s_i, P_i = 2 * s1 * phi[i], by_component(which, phi, e, along, i, c)
                s_ih = 4 * s2 * phi[i] * step + 2 * s1 * rate[i]
                s_ihh = 8 * s3 * phi[i] * step * step + 8 * s2 * step * rate[i] + 4 * s2 * phi[i] * square
                P_ih = 0 * P
                out.by[i, c] += s_i * P + s * P_i
                for m in range(3):
                    s_im = 4 * s2 * phi[i] * phi[m] + (2 * s1 if i == m else 0)
                    s_m, P_m = 2 * s1 * phi[m], by_component(which, phi, e, along, m, c)
                    P_im = twice(which, e, i, m, c)
                    P_ih += P_im * rate[m]
                    out.by_by[i, m, c] += s_im * P + s_i * P_m + s_m * P_i + s * P_im
                out.curved[i, c] += s_ihh * P + s_hh * P_i + 2 * s_ih * P_h + 2 * s_h * P_ih + s_i * P_hh
    for i in range(3):
        for m in range(3):
            for c in range(3):
                out.along_rate[i, c] += out.by_by[i, m, c] * rate[m]
                out.along_growth[i, c] += out.by_by[i, m, c] * growth[m]


@inner
def form(which, phi, rate, e, x, along, step, square, c):
    """Component c of P = phi x e or phi x (phi x e), and its first and second derivative along phi'."""
    if which == 0:
        a, b = (c + 1) % 3, (c + 2) % 3
        return phi[a] * e[b] - phi[b] * e[a], rate[a] * e[b] - rate[b] * e[a], 0 * x
    pull = dot(rate, e)
    return (
        phi[c] * along - x * e[c],
        rate[c] * along + phi[c] * pull - 2 * step * e[c],
        2 * (rate[c] * pull - square * e[c]),
    )


@inner
def by_component(which, phi, e, along, i, c):
    """Component c of the derivative dP/dphi_i."""
    if which == 0:
        return unit_cross(i, e, c)
    return (along if c == i else 0 * along) + phi[c] * e[i] - 2 * phi[i] * e[c]


@inner
def twice(which, e, i, m, c):
    """Component c of the second derivative d2P/dphi_i dphi_m."""
    if which == 0:
        return 0 * e[0]
    return (e[m] if c == i else 0 * e[0]) + (e[i] if c == m else 0 * e[0]) - (2 * e[c] if i == m else 0 * e[0])
