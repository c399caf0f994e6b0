"""A curve of an angle over one turn, as numbers that a row of a joint carries."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from toolkit.curves.curve import Curve
from toolkit.foundation.errors import InputError
from toolkit.joints.kernels.profile import DEGREE, PIECE
from toolkit.joints.rows import Form

TURN = 2 * np.pi
WIDEST, OF_PERIOD = TURN / 16, 1 / 16
"""Longest piece, and longest as a part of a period of the curve: polynomials meet a sine there to 1e-15 of its amplitude."""
CLOSE = 1e-9
"""Distance of corners in rad that are one; and part of the largest value or slope by which a curve may miss itself after one turn."""
MOST = 2000
"""Pieces of a profile."""


def profile_form(curve: Curve) -> Form:
    """The numbers of f(t) - f(0) for t from 0 to 2 pi, as `kernels.profile` reads them, real or complex."""
    nodes = np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))
    powers, start = np.vander(nodes, increasing=True), curve.evaluate(np.zeros(1))[0, 0]
    numbers: list[Any] = []
    for begin, end in _pieces(curve):
        middle, half = (begin + end) / 2, (end - begin) / 2
        found = np.linalg.solve(powers, curve.evaluate(middle + half * nodes)[:, 0] - start)
        numbers += [begin, middle, *(found / half ** np.arange(DEGREE + 1))]
    assert len(numbers) % PIECE == 0
    return Form(linear=tuple((0, number) for number in numbers))


def check_turn(curve: Curve, owner: str) -> None:
    """Refuse a curve that does not come back to its value and slope after one turn.

    Raises
    ------
    InputError
        Says by how much.
    """
    inside = np.linspace(0, TURN, 721)[1:-1]
    ends = np.real(curve.evaluate(np.array([np.nextafter(0.0, 1.0), np.nextafter(TURN, 0.0)])))
    largest = np.abs(np.real(curve.evaluate(inside))[:, :2]).max(axis=0)
    for k, what in enumerate(("value", "slope")):
        if abs(ends[1, k] - ends[0, k]) > CLOSE * largest[k]:
            raise InputError(
                f"the curve of {owner} has the {what} {ends[0, k]:.9g} at the angle 0 and {ends[1, k]:.9g} after a turn, at 2 pi = "
                f"{TURN:.9g}: a cam's follower would jump there. Let it end as it begins; its argument is the angle in rad."
            )


def _pieces(curve: Curve) -> list[tuple[Any, Any]]:
    """Beginning and end of each, within one turn; their number follows from the real parts alone."""
    corners = sorted((c for c in curve.corners() if CLOSE < np.real(c) < TURN - CLOSE), key=np.real)
    bounds: list[Any] = [0.0]
    for corner in corners:
        if np.real(corner - bounds[-1]) > CLOSE:
            bounds.append(corner)
    widest = min((WIDEST, *(OF_PERIOD * period for period in curve.periods())))
    found: list[tuple[Any, Any]] = []
    for begin, end in pairwise([*bounds, TURN]):
        count = int(np.ceil(np.real(end - begin) / widest - CLOSE))
        edges = [begin + (end - begin) * k / count for k in range(count + 1)]
        found += pairwise(edges)
    if len(found) > MOST:
        raise InputError(f"the curve of a cam changes too often within one turn: it takes {len(found)} pieces, {MOST} at most.")
    return found
