"""Points of the path of equilibria where the load turns back, or reaches a given value."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from toolkit.solvers.static.path.corrector import Corrected, correct, measure
from toolkit.solvers.static.path.path_equations import PathEquations
from toolkit.solvers.static.path.path_steps import Arc

EXACT = 1e-12
"""Part of an arc to which a place on it is found; at a limit point the load is exact to the square of it."""
ALLOWED = 0.1
"""Part of an arc by which Newton may correct a point of the cubic through its ends."""
FULL = 1 - 1e-12
"""Load factor that is the full load to round-off."""


class Place(NamedTuple):
    """Point z of the path by its distance from the beginning of an arc, across its planes, and dz by that distance."""

    length: float
    z: np.ndarray
    slope: np.ndarray

    @property
    def loaded(self) -> bool:
        """Whether the point bears the full load, or more."""
        return bool(self.z[-1] >= FULL)


def ends(arc: Arc) -> tuple[Place, Place]:
    """Places at both ends of an arc."""
    cubic = arc.cubic
    return Place(0.0, cubic.begin, cubic.begin_slope), Place(arc.length, cubic.end, cubic.end_slope)


def limit_point(equations: PathEquations, arc: Arc) -> Place | None:
    """Place of an arc where the load turns back, None without one; about that of an arc that is too short to look into."""
    if not arc.turns:
        return None
    if arc.branching:
        return ends(arc)[1]._replace(length=arc.length / 2)
    return _where(equations, arc, *ends(arc), _rate)


def full_load(equations: PathEquations, arc: Arc, first: Place, last: Place) -> Place | None:
    """Place between two of an arc where the load factor is one, if they lie on both sides of it."""
    if first.loaded == last.loaded:
        return None
    near = [place for place in (first, last) if abs(place.z[-1] - 1) <= 1 - FULL]
    return near[0] if near else _where(equations, arc, first, last, _missing_load)


def _rate(place: Place) -> float:
    return float(place.slope[-1])


def _missing_load(place: Place) -> float:
    return float(place.z[-1] - 1)


def _where(equations: PathEquations, arc: Arc, first: Place, last: Place, vanishing: Callable[[Place], float]) -> Place:
    found = {first.length: first, last.length: last}

    def value(length: float) -> float:
        if length not in found:
            found[length] = _place(equations, arc, length)
        return vanishing(found[length])

    from scipy.optimize import brentq  # for limit points alone: it takes longer to import than a wing to solve

    length = brentq(value, first.length, last.length, xtol=EXACT * arc.length, rtol=EXACT)
    value(length)
    return found[length]


def _place(equations: PathEquations, arc: Arc, length: float) -> Place:
    """Place on the path at a distance across the planes of an arc, to round-off."""
    cubic = arc.cubic
    allowed = ALLOWED * measure(equations, cubic.end - cubic.begin)
    point: Corrected = correct(equations, arc.border, cubic.at(length), allowed, exact=True)
    return Place(length, point.z, point.crossing.ahead())
