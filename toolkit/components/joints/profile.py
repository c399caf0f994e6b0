"""A curve of an angle over one turn, as numbers that a row of a joint carries."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from itertools import pairwise
from typing import TypeVar

import numpy as np

from toolkit.components.curves.curve import Curve
from toolkit.components.joints.kernels.profile import DEGREE, PIECE
from toolkit.components.joints.rows import Form
from toolkit.description.description import Scalar
from toolkit.foundation.errors import InputError

R = TypeVar("R")
FULL_TURN = 2 * np.pi
WIDEST_PIECE, PIECE_PER_PERIOD = FULL_TURN / 16, 1 / 16
"""Longest piece, and longest as a part of a period of the curve."""
PIECE_ERROR = 1e-13
"""Largest error of a piece, as a part of the largest value; what misses it is cut into shorter ones."""
CLOSED_TOLERANCE = 1e-9
"""Distance of corners in rad that are one; and part of the largest value or slope by which a curve may miss itself after one turn."""
MOST_PIECES = 2000
"""Pieces of a profile."""
NODES = np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))
BETWEEN = np.append((NODES[:-1] + NODES[1:]) / 2, [-1 + 1e-6, 1 - 1e-6])
"""Places where polynomials meet a piece, and where their error is looked at, from -1 to 1."""
_AT_NODES, _AT_BETWEEN = (np.vander(places, DEGREE + 1, increasing=True) for places in (NODES, BETWEEN))
REMEMBERED_CURVES = 64
"""Curves of which it is remembered what was found: a scene asks its cams again and again, and a curve never changes."""


class _Same:
    """Key of a curve that equals that of the very same curve alone, whatever its numbers are."""

    def __init__(self, curve: Curve) -> None:
        self.curve = curve

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and self.curve is other.curve

    def __hash__(self) -> int:
        return id(self.curve)


def _remembered(function: Callable[[Curve], R]) -> Callable[[Curve], R]:
    known = lru_cache(REMEMBERED_CURVES)(lambda same: function(same.curve))

    @wraps(function)
    def remembering(curve: Curve) -> R:
        return known(_Same(curve))

    return remembering


@_remembered
def profile_form(curve: Curve) -> Form:
    """Form with the numbers of f(t) - f(0) for t from 0 to 2 pi, as `kernels.profile` reads them, real or complex.

    Raises
    ------
    InputError
        The curve changes too often.
    """
    start = curve.evaluate(np.zeros(1))[0, 0]
    largest = np.abs(np.real(curve.evaluate(np.linspace(0, FULL_TURN, 721))[:, 0] - start)).max()
    widest, numbers = min((WIDEST_PIECE, *(PIECE_PER_PERIOD * period for period in curve.periods()))), list[Scalar]()
    for begin, end in pairwise(_bounds(curve)):
        count = max(1, int(np.ceil(np.real(end - begin) / widest - CLOSED_TOLERANCE)))
        while (found := _pieces(curve, start, begin, end, count))[1] > PIECE_ERROR * largest:
            count *= 2
            if count > MOST_PIECES:
                raise InputError(
                    f"the curve of a cam changes too often within one turn: it takes more than {MOST_PIECES} polynomials."
                )
        numbers += found[0]
    assert len(numbers) % PIECE == 0
    return Form(linear=tuple((0, number) for number in numbers))


def _pieces(curve: Curve, start: Scalar, begin: Scalar, end: Scalar, count: int) -> tuple[list[Scalar], float]:
    """Numbers of `count` pieces of equal length, and their largest error."""
    half = (end - begin) / count / 2
    middles = begin + half * (2 * np.arange(count) + 1)
    values, between = (
        curve.evaluate((middles[:, None] + half * x).ravel())[:, 0].reshape(count, -1) - start for x in (NODES, BETWEEN)
    )
    scaled = np.linalg.solve(_AT_NODES, values.T).T
    error = float(np.abs(np.real(scaled @ _AT_BETWEEN.T - between)).max())
    found = np.column_stack([middles - half, middles, scaled / half ** np.arange(DEGREE + 1)])
    return found.ravel().tolist(), error


def check_turn(curve: Curve, owner: str) -> None:
    """Refuse a curve that does not come back to its value and slope after one turn.

    Raises
    ------
    InputError
        Says by how much.
    """
    ends, largest = _turn(curve)
    for k, what in enumerate(("value", "slope")):
        if abs(ends[1, k] - ends[0, k]) > CLOSED_TOLERANCE * largest[k]:
            raise InputError(
                f"the curve of {owner} has the {what} {ends[0, k]:.9g} at the angle 0 and {ends[1, k]:.9g} after a turn, at 2 pi = "
                f"{FULL_TURN:.9g}: a cam's follower would jump there. Let it end as it begins; its argument is the angle in rad."
            )


@_remembered
def _turn(curve: Curve) -> tuple[np.ndarray, np.ndarray]:
    """Values, slopes and more at both ends of one turn, (2, 3), and the largest value and slope inside of it, (2,)."""
    largest = np.abs(np.real(curve.evaluate(np.linspace(0, FULL_TURN, 721)[1:-1]))[:, :2]).max(axis=0)
    return np.real(curve.evaluate(np.array([0.0, FULL_TURN]))), largest


def _bounds(curve: Curve) -> list[Scalar]:
    """Beginning and end of one turn, and corners of the curve between them."""
    corners = sorted((c for c in curve.corners() if CLOSED_TOLERANCE < np.real(c) < FULL_TURN - CLOSED_TOLERANCE), key=np.real)
    bounds: list[Scalar] = [0.0]
    for corner in corners:
        if np.real(corner - bounds[-1]) > CLOSED_TOLERANCE:
            bounds.append(corner)
    return [*bounds, FULL_TURN]
