"""Slopes of cubics through the rows of a table, from the widths h and the mean slopes s of its pieces; zero at both ends."""

from __future__ import annotations

import numpy as np


def cubic_slopes(width: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Slopes m of the cubic spline at its corners, (n,), from widths h and mean slopes s of its pieces, (n - 1,).

    f'' is continuous:  m_(k-1) / h_(k-1) + 2 (1 / h_(k-1) + 1 / h_k) m_k + m_(k+1) / h_k = 3 (s_(k-1) / h_(k-1) + s_k / h_k)
    """
    from scipy.linalg import solve_banded  # for tables alone

    m = np.zeros(len(width) + 1, np.result_type(width, slope))
    if len(m) > 2:
        bands = np.zeros((3, len(m) - 2), width.dtype)
        bands[0, 1:], bands[1], bands[2, :-1] = 1 / width[1:-1], 2 / width[:-1] + 2 / width[1:], 1 / width[1:-1]
        m[1:-1] = solve_banded((1, 1), bands, 3 * (slope[:-1] / width[:-1] + slope[1:] / width[1:]))
    return m


def monotone_slopes(width: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Slopes m of Fritsch and Butland, with which the cubics rise where the rows rise and turn at rows only; arguments as `cubic_slopes`.

        (w_1 + w_2) / m_k = w_1 / s_(k-1) + w_2 / s_k,     w_1 = 2 h_k + h_(k-1),  w_2 = h_k + 2 h_(k-1),
        m_k = 0 where s changes its sign

    Where s becomes zero, m has a kink: its derivative there is the mean of both sides.
    """
    m = np.zeros(len(width) + 1, np.result_type(width, slope))
    before, after = slope[:-1], slope[1:]
    w_1, w_2 = 2 * width[1:] + width[:-1], width[1:] + 2 * width[:-1]
    below = w_1 * after + w_2 * before
    turning, flat = before.real * after.real < 0, (before.real == 0) & (after.real == 0)
    share = np.where(turning | flat, 0.0, np.where(before.real * after.real == 0, 0.5, 1.0))
    m[1:-1] = share * (w_1 + w_2) * before * after / np.where(turning | flat, 1.0, below)
    return m
