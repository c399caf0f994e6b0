"""The joints of a scene whose bodies keep the shape that they have: gaps, and how they change as bodies move and turn."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from toolkit.equations.equations import Inputs, Terms
from toolkit.joints.rigid_joint import Tie
from toolkit.system.system import System

MOST = 400
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
        return self.system.compiled and 0 < len(self.frames) <= MOST and self.system.n > self.system.n_q

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
