"""The joints of a scene whose bodies keep their shapes: gaps, and the positions in which these are smallest.

Positions in which joints are open by as little as possible, by Newton's method with a trust region on the sum of their squared gaps.

Second derivatives tell a position from which no move closes the joints from one that is the furthest from closing, such as a stretched
linkage: its gradient vanishes too, and it is left along its negative curvature.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from toolkit.components.joints.rigid_joint import Tie
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.units import unit
from toolkit.system.equations import Inputs, Terms
from toolkit.system.system import System

MOST_COORDINATES = 400
"""Coordinates of frames up to which mechanisms are looked at: dense matrices take some tenths of a second then."""


@dataclass(frozen=True)
class RigidBodies:
    """Bodies that move as rigid ones, with their joints; gaps and moves in parts of the model size, or in rad."""

    system: System

    @cached_property
    def frames(self) -> np.ndarray:
        """Numbers of the coordinates of frames (n_f,)."""
        scene, first = self.system.scene, self.system.numbering.first
        ranges = [range(first[name], first[name] + body.frame_size) for name, body in scene.all_bodies().items()]
        return np.array([i for each in ranges for i in each], np.int64)

    @property
    def countable(self) -> bool:
        """Whether there are moving bodies and joints, in real numbers, and not too many coordinates."""
        return self.system.compiled and 0 < len(self.frames) <= MOST_COORDINATES and self.system.n > self.system.n_q

    @property
    def bend(self) -> bool:
        """Whether there are bodies whose shape is kept here though it can change."""
        return len(self.frames) < self.system.n_b

    @cached_property
    def rows(self) -> np.ndarray:
        """Numbers of the constraints (n_c,), without those that others imply at the start."""
        return np.setdiff1d(np.arange(self.system.n_q, self.system.n), self.system.plan.dropped)

    @cached_property
    def inner(self) -> np.ndarray:
        """Which of the constraints are no joints of the user, (n_c,).

        They are those of quaternions, and of what ties the parts of a cut body.
        """
        numbering, joints = self.system.numbering, self.system.scene.joints
        ties = [numbering.row[name] + i for name, each in joints.items() if isinstance(each, Tie) for i in range(len(each.rows))]
        return np.isin(self.rows, [*numbering.length.values(), *ties])

    @cached_property
    def _scales(self) -> tuple[np.ndarray, np.ndarray]:
        """Scales that make gaps (n_c,) and moves (n_f,) comparable."""
        return self.system.weights[self.rows], self.system.weights[self.frames]

    def gaps(self, inputs: Inputs, q: np.ndarray) -> np.ndarray:
        """Gaps of all constraints at coordinates q (n,), (n_c,)."""
        return np.real(self._terms(inputs, q, np.zeros_like(q), False).applied)[self.rows] * self._scales[0]

    def jacobian(self, inputs: Inputs, q: np.ndarray) -> np.ndarray:
        """Derivatives of the gaps by the moves, (n_c, n_f)."""
        return self._jacobian(self._terms(inputs, q, np.zeros_like(q), True))

    def linearised(self, inputs: Inputs, q: np.ndarray, stiff: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Gaps (n_c,), their derivatives (n_c, n_f), and sum of stiff gap times its second derivatives (n_f, n_f)."""
        of_gaps, of_moves = self._scales
        gaps = self.gaps(inputs, q)
        forces = np.zeros_like(q)
        forces[self.rows] = stiff * gaps * of_gaps
        terms = self._terms(inputs, q, forces, True)
        bent = np.real(self.system.matrix(terms.I_q)[self.frames][:, self.frames].toarray())
        return gaps, self._jacobian(terms), (bent + bent.T) / 2 / np.outer(of_moves, of_moves)

    def moved(self, q: np.ndarray, move: np.ndarray) -> np.ndarray:
        """Coordinates (n,) after a move (n_f,)."""
        found = q.copy()
        found[self.frames] += move / self._scales[1]
        return found

    def way(self, q: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Move (n_f,) that leads from coordinates to others, both (n,)."""
        return np.real(other - q)[self.frames] * self._scales[1]

    def _jacobian(self, terms: Terms) -> np.ndarray:
        array = np.real(self.system.matrix(terms.A_q)[self.rows][:, self.frames].toarray())
        return array * self._scales[0][:, None] / self._scales[1]

    def _terms(self, inputs: Inputs, q: np.ndarray, forces: np.ndarray, linearize: bool) -> Terms:
        """Terms of the joints alone; every term is new memory or read before the next."""
        return self.system.evaluate(inputs._replace(joints_only=True), q, np.zeros_like(q), forces, linearize=linearize)


CLOSED_GAP = 1e-9
"""Gap, a part of the model size (or rad), that is none."""
MOST_ITERATIONS = 100
FIRST_TRUST_RADIUS, LAST_TRUST_RADIUS = 0.3, 1e-12
"""First and last radius within which a model of second order is believed, in parts of the model size (or rad)."""
FLAT_CURVATURE = 1e-9
"""Part of the largest curvature below which one is round-off."""
LEAST_GAIN = 1e-13
"""Part of the sum of squares by which a step has to lessen it, to be worth taking."""
CLOSED_GAP_WEIGHT = 1e3
"""Factor by which a gap that is to stay closed counts more than others; each time when the search begins anew."""


class Nearest(NamedTuple):
    """Coordinates (n,), and gaps of all constraints there (n_c,), in parts of the model size (or rad)."""

    q: np.ndarray
    gaps: np.ndarray

    @property
    def closes(self) -> bool:
        """Whether every joint is closed."""
        return bool(np.abs(self.gaps).max() <= CLOSED_GAP)


def nearest(bodies: RigidBodies, inputs: Inputs, q: np.ndarray, soft: np.ndarray | None = None) -> Nearest:
    """Position where all gaps are smallest, or those of `soft` constraints (n_c,) while the others stay closed; from q on."""
    hard = bodies.inner if soft is None else ~soft
    found = Nearest(q, bodies.gaps(inputs, q))
    for factor in (CLOSED_GAP_WEIGHT**0.5, CLOSED_GAP_WEIGHT, CLOSED_GAP_WEIGHT**1.5):
        found = _descended(bodies, inputs, found.q, np.where(hard, factor**2, 1.0))
        if found.closes or not np.any(hard):
            break
    return found


def _descended(bodies: RigidBodies, inputs: Inputs, q: np.ndarray, stiff: np.ndarray) -> Nearest:
    """Position where the sum of squared gaps is smallest, for weights `stiff` of the squares (n_c,)."""
    radius, gaps = FIRST_TRUST_RADIUS, bodies.gaps(inputs, q)
    for _ in range(MOST_ITERATIONS):
        gaps, slopes, bent = bodies.linearised(inputs, q, stiff)
        move, foreseen = _step(slopes.T @ (stiff * gaps), slopes.T @ (stiff[:, None] * slopes) + bent, radius)
        before = stiff @ gaps**2 / 2
        if np.abs(gaps).max() <= CLOSED_GAP or radius < LAST_TRUST_RADIUS or foreseen <= LEAST_GAIN * before:
            break
        trial = bodies.moved(q, move)
        after = stiff @ bodies.gaps(inputs, trial) ** 2 / 2
        good = (before - after) / foreseen
        radius = min(2 * radius, FIRST_TRUST_RADIUS) if good > 0.7 else radius / 4 if not good > 0.2 else radius
        q = trial if after < before else q
    return Nearest(q, bodies.gaps(inputs, q))


def _step(gradient: np.ndarray, curvature: np.ndarray, radius: float) -> tuple[np.ndarray, float]:
    """Newton's step downhill, no longer than the radius, and the predicted decrease of the sum."""
    sizes, motions = np.linalg.eigh(curvature)
    least = FLAT_CURVATURE * np.abs(sizes).max()
    pull = motions.T @ gradient
    step = -pull / np.maximum(np.abs(sizes), least)
    if sizes[0] < -least and abs(step[0]) < radius / 2:
        side = motions[first_largest(np.abs(motions[:, 0])), 0]
        step[0] = radius / 2 * (-np.sign(pull[0]) if abs(pull[0]) > least * radius else np.sign(side))
    step *= min(1.0, radius / max(float(np.abs(step).max()), radius))
    return motions @ step, float(-pull @ step - sizes @ step**2 / 2)


def opening(system: System, row: int, violation: float) -> float:
    """Gap of a constraint, a length or an angle, where it is violated by so much.

    The constraint is given by its number among all unknowns.
    """
    name, within = joint_of(system, row)
    return (
        violation if name is None else float(system.scene.joints[name].opening(system.scene, within, float(np.real(violation))))
    )


def joint_of(system: System, row: int) -> tuple[str | None, int]:
    """Joint that a constraint belongs to, and which of its rows it is; None for the length of a quaternion."""
    for name, first in system.numbering.row.items():
        if first <= row < first + len(system.scene.joints[name].rows):
            return name, row - first
    return None, 0


def label(system: System, row: int) -> str:
    """Unit in which a constraint is open: that of lengths, or rad."""
    name, within = joint_of(system, row)
    if name is None:
        return ""
    return unit(system.scene.units, system.scene.joints[name].rows[within][1])


def told(system: System, row: int, violation: float) -> str:
    """Text of the gap of a constraint, with its unit."""
    return f"{opening(system, row, violation):.3g} {label(system, row)}".rstrip()
