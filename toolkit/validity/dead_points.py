"""Dead points that a motion passes: positions in which joints repeat each other, so that bodies may go on in two ways.

Dead points that a motion passes: positions in which joints repeat each other, so that bodies can go on from them in two ways.

    sign det [J(q_n); N^T] != sign det [J(q_n+1); N^T],     J(q_n) N = 0

The Jacobian J of the joints loses its rank between two states where this sign changes, the test of continuation methods for branches
(Keller 1977). A parallelogram passes such a position. Of one whose lengths are a little off, both branches come close to each other
without meeting, and a step may jump from one to the other. Two dead points at the same time change the sign twice, and are not seen.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from toolkit.foundation.near_ties import spread
from toolkit.foundation.verdict import Caution, check
from toolkit.solvers.static.critical_state import StaticEntries
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.system.equations import Terms
from toolkit.system.solution import Solution
from toolkit.system.system import System

CORRECTIONS = 6
"""Number of corrections by which coordinates are put back on the joints."""
SINGULAR_JOINTS = 1e-5
"""Smallest singular value, relative to the largest, up to which joints repeat each other: its square is the accuracy of
positions there."""
OPENING_PART = 1e-3
"""Part of a variable's change of the gaps that must do work to open a dead point; less is round-off."""


@dataclass(frozen=True)
class JointsAlone:
    """Joints of a system that no others repeat; gaps and coordinates are relative to the model size (or in rad)."""

    system: System

    @cached_property
    def _kept(self) -> np.ndarray:
        return np.setdiff1d(np.arange(self.system.n_q, self.system.n), self.system.plan.dropped)

    @cached_property
    def _rest(self) -> np.ndarray:
        return np.zeros(self.system.n)

    def _terms(self, time: float, q: np.ndarray, design: bool = False) -> Terms:
        inputs = self.system.inputs(time, LEVELS)._replace(joints_only=True)
        padded = np.append(q, np.zeros(self.system.n - self.system.n_q))
        return self.system.evaluate(inputs, padded, self._rest, self._rest, design=design)

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Constraint Jacobian J (n_lam, n_q), which does not depend on time."""
        return self.jacobians(q[None])[0]

    def jacobians(self, states: np.ndarray) -> np.ndarray:
        """Constraint Jacobians of several states (k, n_q), (k, n_lam, n_q)."""
        system, weights = self.system, self.system.weights
        q, rest = np.zeros((2, len(states), system.n))
        q[:, : system.n_q] = states
        curves, curves_x = system.curves(np.zeros(1))
        always = curves.repeat(len(states), axis=0), curves_x.repeat(len(states), axis=0)
        found = system.evaluate_states(always, LEVELS, q, rest, rest, joints_only=True)
        entries = StaticEntries.on_pattern(system, np.stack([each.I_acc for each in found]))
        arrays = entries.block(np.arange(system.n_q), self._kept).transpose(0, 2, 1)
        return arrays * weights[self._kept, None] / weights[: system.n_q]

    def closed(self, time: float, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Time, and coordinates put back on the joints by the smallest moves."""
        weights = self.system.weights
        for _ in range(CORRECTIONS):
            q = q - np.linalg.pinv(self.jacobian(q), rcond=SINGULAR_JOINTS) @ self.gaps(time, q) / weights[: self.system.n_q]
        return time, q

    def gaps(self, time: float, q: np.ndarray) -> np.ndarray:
        """Constraint violations of the joints (n_lam,)."""
        return np.real(self._terms(time, q).applied)[self._kept] * self.system.weights[self._kept]

    def doing_work(self, time: float, q: np.ndarray, forces: np.ndarray) -> tuple[str, ...]:
        """Design variables by which the gaps change so that these forces of joints do work."""
        changes = np.real(self._terms(time, q, design=True).A_x)[self._kept] * self.system.weights[self._kept, None]
        work, largest = np.abs(forces @ changes), np.linalg.norm(changes, axis=0)
        names = self.system.design.names
        return tuple(name for name, each, size in zip(names, work, largest, strict=True) if each > OPENING_PART * size)


MOST_COORDINATES, MOST_EXAMINED = 60, 200
"""Largest number of coordinates of scenes that are examined, and of states."""
COMPARABLE_DIRECTIONS = 0.5
"""Determinant of the cosines between the free motions of two states from which on their signs can be compared."""
HALVINGS = 40
"""Number of bisections by which a dead point is found between two states."""
CLOSED_VIOLATION = 1e-9
"""Constraint violation, relative to the model size (or in rad), that counts as zero: where lengths are off by more,
branches do not meet."""


@dataclass(frozen=True)
class DeadPoint:
    """A dead point that a motion passes.

    Attributes
    ----------
    time
        Time of the passage.
    meets
        Whether the branches meet there; otherwise a step has jumped.
    opened_by
        Design variables whose change parts the branches.
    """

    time: float
    meets: bool
    opened_by: tuple[str, ...]


def dead_points(solution: Solution) -> list[DeadPoint]:
    """Dead points between the states of a motion, in the order of time."""
    system = solution.system
    if not (system.compiled and solution.steps and system.n_q <= MOST_COORDINATES and _has_loops(system)):
        return []
    joints = JointsAlone(system)
    coarse = _changes(solution, joints, spread(len(solution.times) - 1, MOST_EXAMINED))
    steps = [each for low, high, _ in coarse for each in _changes(solution, joints, range(low, high + 1))]
    found = (_between(solution, joints, *each) for each in steps)
    return [each for each in found if each is not None]


def _changes(solution: Solution, joints: JointsAlone, states: Sequence[int]) -> list[tuple[int, int, np.ndarray]]:
    """Neighbours among some states between which the sign changes, and the free motions (f, n_q) of the first."""
    arrays = joints.jacobians(np.real(solution.q[list(states)]))
    free = np.linalg.qr(arrays.transpose(0, 2, 1), mode="complete")[0][:, :, arrays.shape[1] :].transpose(0, 2, 1)
    changed = _sides(arrays[1:], free[:-1]) * _sides(arrays[:-1], free[:-1]) < 0
    found = changed & _alike(free[1:], free[:-1])
    return [(*pair, free[n]) for n, pair in enumerate(pairwise(states)) if found[n]]


def _alike(free: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Whether free motions (..., f, n_q) are so alike that they do not change the sign themselves."""
    return np.abs(np.linalg.det(free @ np.swapaxes(others, -1, -2))) > COMPARABLE_DIRECTIONS


def _has_loops(system: System) -> bool:
    """Whether joints tie bodies to each other in more than one way."""
    pairs = {frozenset(joint.bodies) for joint in system.scene.joints.values()}
    bodies = {body for pair in pairs for body in pair}
    return len(pairs) >= len(bodies) > 0


def _sides(jacobians: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Signs of the determinants of Jacobians (..., n_lam, n_q) with free motions (..., f, n_q) below them."""
    return np.linalg.slogdet(np.concatenate([jacobians, free], axis=-2))[0]


def _between(solution: Solution, joints: JointsAlone, low: float, high: float, free: np.ndarray) -> DeadPoint | None:
    """Dead point between two states, found by bisection; None if the free motions have turned instead."""

    def closed(place: float) -> tuple[float, np.ndarray]:
        return joints.closed(*_state(solution, place))

    side = _sides(joints.jacobian(closed(low)[1]), free)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        beyond = _sides(joints.jacobian(closed(middle)[1]), free) * side < 0
        low, high = (low, middle) if beyond else (middle, high)
    ends = [closed(place) for place in (low, high)]
    arrays = [joints.jacobian(q) for _, q in ends]
    singular = [np.linalg.svd(each) for each in arrays]
    if not all(_alike(turned[len(array) :], free) for array, (_, _, turned) in zip(arrays, singular, strict=True)):
        return None
    repeated = all(values[-1] <= SINGULAR_JOINTS * values[0] for _, values, _ in singular)
    meets = repeated and all(np.abs(joints.gaps(*each)).max() <= CLOSED_VIOLATION for each in ends)
    return DeadPoint(ends[0][0], meets, joints.doing_work(*ends[0], singular[0][0][:, -1]))


def _state(solution: Solution, place: float) -> tuple[float, np.ndarray]:
    """Time and coordinates at a place between two states, by a straight line."""
    n = min(int(place), len(solution.times) - 2)
    time, q = ((1 - (place - n)) * each[n] + (place - n) * each[n + 1] for each in (solution.times, np.real(solution.q)))
    return float(time), q


def dead_points_passed(solution: Solution, variables: Collection[str]) -> Iterator[Caution]:
    """A doubt where a step has jumped between two branches, and about derivatives by what opens a dead point; else a remark."""
    found = dead_points(solution)
    passed = [each for each in found if each.meets]
    yield from jumped([each for each in found if not each.meets])
    yield from straight_on(passed)
    yield from opened(passed, variables)


@check("jumped")
def jumped(found: Sequence[DeadPoint]) -> Iterator[Caution]:
    """A step has jumped from one way of assembling the bodies to another, with no way between them.

    Limit: joints that stay open by more than 1e-9 of the model size.
    Fix: lengths that fit to the last digit, or much smaller steps.
    """
    if found:
        yield jumped.caution(
            f"at t = {found[0].time:.4g} a step has jumped from one way of assembling the bodies to another, between which the joints "
            "leave no way: lengths that are a little off have opened a dead point. Fix: lengths that fit to the last digit, if the bodies "
            "are to pass it; much smaller steps, if they are to turn over there.",
        )


@check("dead-point")
def straight_on(found: Sequence[DeadPoint]) -> Iterator[Caution]:
    """The motion passes a dead point, where bodies could go on in two ways, and went straight on.

    Limit: joints that repeat each other to 1e-5.
    Fix: nothing if it is meant; another way takes lengths that are a little off.
    """
    if found:
        yield straight_on.caution(
            f"at t = {found[0].time:.4g} the motion passes a dead point: joints repeat each other, and bodies could go on in two ways. It "
            "went straight on. With lengths that are a little off they turn over or jam there.",
            doubt=False,
        )


@check("gradient-dead-point")
def opened(found: Sequence[DeadPoint], variables: Collection[str]) -> Iterator[Caution]:
    """Derivatives by what opens a dead point do not exist; what is told is that along the branch that was taken.

    Limit: 1e-3 of what a variable changes at the joints.
    Fix: do not search over such a variable.
    """
    times = {name: each.time for each in found for name in each.opened_by if name in variables}
    if times:
        yield opened.caution(
            f"derivatives by {', '.join(times)} do not exist: any change of it opens the dead point at t = {min(times.values()):.4g}, and "
            "bodies turn over or jam there. What is told is the derivative along the branch that this run took.",
        )
