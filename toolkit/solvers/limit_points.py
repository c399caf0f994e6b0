"""Where along the path of equilibria the load turns back, or reaches a given value."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from scipy.optimize import brentq

from toolkit.run_options import RunOptions
from toolkit.solvers.arc_length import Arc, PathPoint, advance
from toolkit.system import System

EXACT = 1e-12
"""Part of an arc to which a place on it is found; at a limit point the load is exact to the square of it."""


class Place(NamedTuple):
    """A point of the path, by its distance from the beginning of an arc."""

    length: float
    point: PathPoint


def limit_point(system: System, options: RunOptions, arc: Arc) -> Place | None:
    """The point of an arc where d factor / ds = 0, if there is one."""
    if (arc.begin.rate > 0) == (arc.end.rate > 0):
        return None
    return _where(system, options, arc, Place(0.0, arc.begin), Place(arc.length, arc.end), _rate)


def full_load(system: System, options: RunOptions, arc: Arc, first: Place, last: Place) -> Place | None:
    """The point between two places of an arc where the load factor is one, if they lie on both sides of it."""
    if (first.point.factor < 1) == (last.point.factor < 1):
        return None
    return _where(system, options, arc, first, last, _missing_load)


def _rate(point: PathPoint) -> float:
    return point.rate


def _missing_load(point: PathPoint) -> float:
    return point.factor - 1.0


def _where(
    system: System, options: RunOptions, arc: Arc, first: Place, last: Place, vanishing: Callable[[PathPoint], float]
) -> Place:
    def value(length: float) -> float:
        return vanishing(advance(system, options, arc.begin, length)[0] if length else arc.begin)

    length = brentq(value, first.length, last.length, xtol=EXACT * arc.length, rtol=EXACT)
    return Place(length, advance(system, options, arc.begin, length)[0] if length else arc.begin)
