"""The joints of a system alone: their gaps and Jacobian, and coordinates that are put back on them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from toolkit.equations.equations import Terms
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.solvers.static.stability.many_states import StaticEntries
from toolkit.system.system import System

CORRECTIONS = 6
"""How often coordinates are put back on the joints."""
SINGULAR = 1e-5
"""Smallest singular value, in parts of the largest, up to which joints repeat each other: its square is what places are known to there."""
OPENS = 1e-3
"""Part of what a variable changes at the joints that opens a dead point; less is round-off."""


@dataclass(frozen=True)
class JointsAlone:
    """Joints of a system that no others repeat, with gaps and coordinates in parts of the scene's size (or rad)."""

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
        """J (n_lam, n_q), which knows no time."""
        return self.jacobians(q[None])[0]

    def jacobians(self, states: np.ndarray) -> np.ndarray:
        """The same of several states (k, n_q), (k, n_lam, n_q)."""
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
        """Coordinates put back on the joints by the smallest moves."""
        weights = self.system.weights
        for _ in range(CORRECTIONS):
            q = q - np.linalg.pinv(self.jacobian(q), rcond=SINGULAR) @ self.gaps(time, q) / weights[: self.system.n_q]
        return time, q

    def gaps(self, time: float, q: np.ndarray) -> np.ndarray:
        """Those of the joints (n_lam,)."""
        return np.real(self._terms(time, q).applied)[self._kept] * self.system.weights[self._kept]

    def doing_work(self, time: float, q: np.ndarray, forces: np.ndarray) -> tuple[str, ...]:
        """Design variables by which the gaps change so that these forces of joints do work."""
        changes = np.real(self._terms(time, q, design=True).A_x)[self._kept] * self.system.weights[self._kept, None]
        work, largest = np.abs(forces @ changes), np.linalg.norm(changes, axis=0)
        names = self.system.design.names
        return tuple(name for name, each, size in zip(names, work, largest, strict=True) if each > OPENS * size)
