"""The designs that one search has solved: each once, as many as the study allows, and the best of them.

Variables in which what is minimised is about as curved in all directions.

    z = z_0 + T y,   T = V |W|^(-1/2),   H = V W V^T

with H the second derivative of the objective at z_0, where the responses tell it. Else it is that of the Lagrangian by the gradients of all
designs that were solved, by the updates of Broyden, Fletcher, Goldfarb and Shanno, damped as Powell has it: first with the designs farthest
from z_0, last with the nearest. A method that begins with the identity then knows the valley in which it stands, and does not have to learn
it anew along its own path.

Planes that cut off designs which could not be solved, as further constraints: a search may go on along them.

    FAILED_DESIGN_PART |d| - (z - z_0) . d / |d| >= 0,    d = z_failed - z_0

from the last design z_0 that could. A box about z_0 would stop the search in all other directions too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from toolkit.studies.optimization.methods import DesignFailedError, Functions
from toolkit.studies.optimization.program import Optimality, Program, Values, optimality_of, promised
from toolkit.studies.store import DesignOutcome

LEAST_CURVATURE_PART = 1e-4
"""Curvature, in parts of the largest, below which no direction is taken to be flatter."""
LONGEST_FIRST_STEP = 0.5
"""Longest first step along any direction, in parts of the variables' ranges: where nothing bends, curvature does not say how far to go."""
LEAST_CURVATURE, POWELL_DAMPING = 1e-6, 0.2
"""First curvature at least; and the part of the known curvature along a step that an update leaves at least (Powell, 1978)."""


class Known(NamedTuple):
    """A design that was solved: z (n,), and its functions."""

    z: np.ndarray
    values: Values


class Turned:
    """Variables y about a design z_0.

    Parameters
    ----------
    centre
        z_0, (n,).
    axes
        T, (n, n).
    top
        Largest z; the least is zero.
    """

    def __init__(self, centre: np.ndarray, axes: np.ndarray, top: np.ndarray) -> None:
        self.centre, self.axes, self.top = centre, axes, top

    def z(self, y: np.ndarray) -> np.ndarray:
        """The design of a y."""
        found: np.ndarray = self.centre + self.axes @ y
        return found

    def functions(self, functions: Functions) -> Functions:
        """The functions of y, with the bounds of all z as constraints after the others."""

        def of(y: np.ndarray) -> Values:
            z = self.z(y)
            found = functions(z)
            c = np.concatenate([found.c, z, self.top - z])
            dc = np.vstack([found.dc.reshape(-1, len(z)) @ self.axes, self.axes, -self.axes])
            curvature = None if found.curvature is None else self.axes.T @ found.curvature @ self.axes
            return Values(found.f, found.df @ self.axes, c, dc, curvature)

        return of


def turned(
    centre: Known, others: Sequence[Known], multipliers: np.ndarray, top: np.ndarray, reach: float = LONGEST_FIRST_STEP
) -> Turned | None:
    """Variables by the curvature about a design; None where neither its responses nor enough other designs tell it.

    Parameters
    ----------
    centre
        The design.
    others
        All that were solved.
    multipliers
        Of the constraints at the centre, (m,).
    top
        Largest z.
    reach
        Longest first step.
    """
    found = centre.values.curvature
    if found is None:
        found = _learned(centre, others, multipliers)
    if found is None:
        return None
    curved, directions = np.linalg.eigh(found)
    steep = np.abs(_slope(centre.values, multipliers) @ directions)
    return Turned(
        centre.z, directions / np.sqrt(np.maximum(curved, np.maximum(LEAST_CURVATURE_PART * curved[-1], steep / reach))), top
    )


def _learned(centre: Known, others: Sequence[Known], multipliers: np.ndarray) -> np.ndarray | None:
    """Second derivative of the Lagrangian at the centre by the gradients of other designs, None where these are too few."""
    n = len(centre.z)
    ways = [(each.z - centre.z, _slope(each.values, multipliers) - _slope(centre.values, multipliers)) for each in others]
    ways = sorted((each for each in ways if each[0] @ each[0] > 0), key=lambda each: -float(each[0] @ each[0]))
    if len(ways) < n:
        return None
    step, change = ways[0]
    found = np.eye(n) * max(abs(step @ change) / (step @ step), LEAST_CURVATURE)
    for step, change in ways:
        found = _updated(found, step, change)
    return found


def _slope(values: Values, multipliers: np.ndarray) -> np.ndarray:
    """Gradient of the Lagrangian, (n,)."""
    found: np.ndarray = values.df - multipliers @ values.dc
    return found


def _updated(matrix: np.ndarray, step: np.ndarray, change: np.ndarray) -> np.ndarray:
    """The matrix, positive definite as before, after the change of the gradient along a step."""
    image, along = matrix @ step, float(step @ matrix @ step)
    met = float(step @ change)
    part = 1.0 if met >= POWELL_DAMPING * along else (1 - POWELL_DAMPING) * along / (along - met)
    change = part * change + (1 - part) * image
    found: np.ndarray = matrix - np.outer(image, image) / along + np.outer(change, change) / float(step @ change)
    return found


FAILED_DESIGN_PART = 0.5
"""Part of the way to a failed design up to which a search may go."""
PLANE_DISTANCE = 0.05
"""Distance to a plane, in parts of that way, below which a search stands at it."""
SHORTEST_WAY = 1e-5
"""Length of that way, in parts of the variables' ranges, below which nothing is left of it."""


class Plane(NamedTuple):
    """normal . z <= limit, half-way along a way of some length."""

    normal: np.ndarray
    limit: float
    length: float


class Cuts:
    """Planes, none at first."""

    def __init__(self) -> None:
        self._planes: list[Plane] = []
        self._patience, self._waited, self._released = 1, 0, False

    def add(self, good: np.ndarray, failed: np.ndarray) -> bool:
        """Cut off a failed design, which was sought from a good one; whether they are far enough from each other."""
        if self._released:
            self._patience *= 2
        self._released, self._waited = False, 0
        way = failed - good
        length = float(np.sqrt(way @ way))
        if length < SHORTEST_WAY:
            return False
        self._planes.append(Plane(way / length, FAILED_DESIGN_PART * length + float(good @ way) / length, length))
        return True

    def release(self, z: np.ndarray) -> None:
        """Forget the planes at which a search stands: what failed once, far behind them, is no reason to stay there. Where the next design
        fails again, it waits twice as long the next time."""
        self._waited += 1
        if self._waited >= self._patience:
            kept = [each for each in self._planes if each.limit - each.normal @ z > PLANE_DISTANCE * each.length]
            self._released = self._released or len(kept) < len(self._planes)
            self._planes = kept

    def around(self, functions: Functions) -> Functions:
        """The functions with the planes as further constraints."""
        if not self._planes:
            return functions
        normals, limits = np.array([each.normal for each in self._planes]), np.array([each.limit for each in self._planes])

        def within(z: np.ndarray) -> Values:
            found = functions(z)
            slopes = np.vstack([found.dc.reshape(-1, len(z)), -normals])
            return found._replace(c=np.concatenate([found.c, limits - normals @ z]), dc=slopes)

        return within


class Ended(Exception):
    """Why a method is to stop; no error."""


class Arrived(Ended):
    """The conditions of an optimum are met."""


class Renewed(Ended):
    """A method is to begin anew, or the next one: so many designs were solved."""


class Spent(Ended):
    """No more designs may be solved, or no more may fail."""


@dataclass(frozen=True)
class SearchResult:
    """How one search ended.

    Attributes
    ----------
    lane
        Its number in the store.
    best
        The design where it ended: feasible and of the least objective, or else the one that violates its constraints least; None if not one
        could be solved.
    optimality
        What is left of the conditions there.
    program
        The functions as they were scaled.
    ended
        Why it ended, in words.
    evaluations, failed
        Designs solved, and how many of them failed.
    """

    lane: int
    start: np.ndarray
    best: DesignOutcome | None
    optimality: Optimality | None
    program: Program
    ended: str
    evaluations: int
    failed: int
    arrived: bool


LARGEST_FIRST_SLOPE = 0.2
"""Largest derivative of the scaled objective at the first design: a method whose first matrix is the identity goes so far at first."""
TYPICAL_DESIGNS = 0.25
"""Part of the designs whose largest derivative is below what is typical: wild ones from the beginning of a search do not count."""
Solve = Callable[[np.ndarray], DesignOutcome]
"""Solves a design, or takes it from where it is kept."""


class Explored:
    """What one search knows.

    Parameters
    ----------
    program
        The functions; they are measured anew where a method begins.
    solve
        Solves a design.
    """

    def __init__(self, program: Program, solve: Solve) -> None:
        self.program, self.solve = program, solve
        self.options = program.problem.study.search
        self.done: dict[bytes, DesignOutcome] = {}
        self.passed: set[bytes] = set()
        """Designs that meet the conditions of an optimum and are none."""

    @property
    def failed(self) -> int:
        """Designs that could not be solved."""
        return sum(each.failed for each in self.done.values())

    @property
    def known(self) -> list[Known]:
        """All others."""
        solved = (each for each in self.done.values() if not each.failed)
        return [Known(self.program.scaled(each.design), self.program.values(each)) for each in solved]

    @property
    def typical(self) -> float:
        """What a large change of the scaled objective is: as the study says, or as the designs that were solved do."""
        given = self.program.problem.study.objective.scale
        if given is not None:
            return given / self.program.unit
        slopes = [np.max(np.abs(self.program.values(each).df)) for each in self.done.values() if not each.failed]
        return float(np.quantile(slopes, TYPICAL_DESIGNS))

    def measure_by(self, values: Values) -> None:
        """Set the unit of the objective by its slopes where a method begins."""
        size = float(np.max(np.abs(values.df)))
        self.program = replace(self.program, unit=self.program.unit * (size / LARGEST_FIRST_SLOPE if size > 0 else 1.0))

    def evaluated(self, design: np.ndarray) -> DesignOutcome:
        """The design, which counts if it is new."""
        key = design.tobytes()
        if key not in self.done:
            if len(self.done) >= self.options.evaluations:
                raise Spent(f"{self.options.evaluations} designs were solved, as many as the study allows")
            found = self.done[key] = self.solve(design)
            if found.failed and self.failed >= self.options.most_failures:
                raise Spent(f"{self.failed} designs could not be solved, as many as the study allows")
        return self.done[key]

    def functions(self, z: np.ndarray) -> Values:
        """F and c at z; a design that cannot be solved ends the method."""
        found = self.evaluated(self.program.design(z))
        if found.failed and self.options.failures == "stop":
            raise Spent("a design could not be solved, and the study says to stop there")
        if found.failed:
            raise DesignFailedError(np.array(z))
        return self.program.values(found)

    def left(self, z: np.ndarray, values: Values) -> Optimality:
        """What is left of the conditions of an optimum."""
        return optimality_of(self.program, z, values, self.typical)

    def best(self) -> tuple[DesignOutcome | None, Optimality | None]:
        """The feasible design of the least objective, else the least violated one; with what is left of the conditions."""
        judged = []
        solved = [each for each in self.done.values() if not each.failed]
        if not solved:
            return None, None
        typical = self.typical
        for found in solved:
            values = self.program.values(found)
            left = optimality_of(self.program, self.program.scaled(found.design), values, typical)
            feasible = left.violation <= self.options.feasibility
            met = left.met(self.options.optimality, self.options.feasibility) and found.design.tobytes() not in self.passed
            judged.append(((not met, not feasible,
                            values.f if feasible else left.violation), found, left))  # fmt: skip
        _, found, left = min(judged, key=lambda each: each[0])
        return found, left

    def stand(self, near: float = 0.0) -> np.ndarray:
        """z of the design from which a method begins anew: the best so far. With `near`, until one meets the conditions of an optimum, the
        one from which curvature and slopes promise the lowest objective by steps of at most that part of the ranges: a design that was
        refused because it lies beside the floor of a bent valley may be far ahead along it, and one short step leads back to the floor.
        """
        best, left = self.best()
        assert best is not None
        assert left is not None
        feasible = [each for each in self.known if np.min(each.values.c, initial=0.0) >= -self.options.feasibility]
        if near == 0 or not feasible or left.met(self.options.optimality, self.options.feasibility):
            return self.program.scaled(best.design)
        return min(feasible, key=lambda each: self._promises(each, near * self.program.top)).z

    def _promises(self, known: Known, steps: np.ndarray) -> float:
        """The least objective that steps of at most so much in every variable, (n,), promise."""
        z, values = known
        return values.f - promised(np.minimum(z, steps), np.minimum(self.program.top - z, steps), values)
