"""A target shape for a skin that has none: the same skin with its nose drooped, without stretching it anywhere.

The droop is a change of curvature of the material line, so that every point keeps its arc length from F. With tau = s / L,

    dk(tau) = w(tau) / L [c_0 + c_1 cos(pi tau) + c_2 cos(2 pi tau)],   w = S(tau / 0.1) S((1 - tau) / 0.1),   S(q) = q^2 (3 - 2 q)
    dtheta(s) = int_0^s dk ds,   r_1(s) = r_0(s) + int_0^s [(cos, sin)(theta_0 + dtheta) - (cos, sin)(theta_0)] ds

and c such that slope and height at G stay, and the leading edge sinks by the wanted depth.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import cumulative_simpson
from scipy.optimize import fsolve

from preprocessing.curve.contour import Contour
from preprocessing.curve.skin import Skin
from toolkit.foundation.errors import InputError

SAMPLES = 2001
"""Arc lengths along the skin at which the integrals are taken; errors of Simpson's rule are far below the rows' last digit."""

ROWS = 161
"""Rows of the target between F and G: close enough for a spline to follow any nose."""

CLOSED = 0.15
"""Behind G the lower side returns to the undeformed one within this part of the chord."""


def drooped(contour: Contour, skin: Skin, depth: float, chord: float) -> np.ndarray:
    """Rows (n, 2) of the contour with its nose sunk by `depth`, trailing edge, upper side, nose, lower side.

    Parameters
    ----------
    contour, skin : the undeformed section and its skin
    depth : how far the leading edge sinks, in the unit of the contour

    Raises
    ------
    InputError
        No such droop exists; it is too deep for this section.
    """
    s = np.linspace(0, skin.length, SAMPLES)
    place, angle, nose = skin.position(s), skin.tangent_angle(s), contour.leading_edge - skin.start

    def moved(c: np.ndarray) -> tuple[np.ndarray, float]:
        turn = cumulative_simpson(_change(s / skin.length, c) / skin.length, x=s, initial=0)
        pairs = ((np.cos, 0), (np.sin, 1))
        shift = [cumulative_simpson(f(angle + turn) - f(angle), x=s, initial=0) for f, _ in pairs]
        return place + np.stack(shift, axis=1), turn[-1]

    def misses(c: np.ndarray) -> list[float]:
        line, slope = moved(c)
        sunk = np.interp(nose, s, line[:, 1] - place[:, 1])
        return [slope, (line[-1, 1] - place[-1, 1]) / depth, sunk / depth + 1]

    c, _, found, _ = fsolve(misses, np.array([0.0, 50 * depth / chord * 0.5, 0.0]), full_output=True)
    if found != 1:
        raise InputError(f"the nose cannot droop by {depth:g} with slope and height kept at G. Choose a smaller depth.")
    line, _ = moved(c)
    return _completed(contour, skin, line[:: (SAMPLES - 1) // (ROWS - 1)], chord)


def _change(tau: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Change of curvature L dk at tau = s / L."""
    window = _step(tau / 0.1) * _step((1 - tau) / 0.1)
    return window * (c[0] + c[1] * np.cos(np.pi * tau) + c[2] * np.cos(2 * np.pi * tau))


def _step(q: np.ndarray) -> np.ndarray:
    q = np.clip(q, 0, 1)
    return q * q * (3 - 2 * q)


def _completed(contour: Contour, skin: Skin, line: np.ndarray, chord: float) -> np.ndarray:
    """The moved skin between the rows before F and those behind G, which follow G's slide and fade out of it."""
    rows, at = contour.position(contour.curve.point_s), contour.curve.point_s
    gap = 0.5 * skin.length / ROWS
    before, behind = rows[at < skin.start - gap], rows[at > skin.end + gap].copy()
    slide = line[-1] - skin.position(skin.length)
    behind += slide * (1 - _step((behind[:, :1] - skin.position(skin.length)[0]) / (CLOSED * chord)))
    return np.vstack([before, line, behind])
