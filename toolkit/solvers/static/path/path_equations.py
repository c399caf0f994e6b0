"""The equations of a path of equilibria: residual(z) = 0 for z = [q; lam; factor], all of them real."""

from __future__ import annotations

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.equations.equations import Inputs, Terms
from toolkit.solvers.static.acting import Acting
from toolkit.solvers.static.stability.saddle import balance
from toolkit.solvers.static.stability.static_array import StaticArray, static_array
from toolkit.system.system import System


class PathEquations:
    """Equations of a path of equilibria of a scene under what acts.

    Of a complex step the path is that of its real design: real parts alone decide where it goes.
    """

    def __init__(self, system: System, options: RunOptions, acting: Acting) -> None:
        self.system, self.options, self.acting = system, options, acting
        self.n, self.n_q = system.n, system.n_q
        self.scale = np.ones(system.n)
        self._rest: np.ndarray = np.zeros(system.n, system.dtype)
        joints = system.plan.joints
        driven = joints.curve >= 0
        self._drivers, self._driven = joints.curve[driven], joints.row[driven] + joints.n_rows[driven] - 1

    def begin(self, z: np.ndarray) -> None:
        """Take the sizes of the equations' terms from a point, for the whole path."""
        self.scale = balance(self.system, self.linearised(z)[1])

    def linearised(self, z: np.ndarray) -> tuple[np.ndarray, StaticArray]:
        """Residual (n,) and its derivative by [q; lam], (n, n)."""
        terms = self._terms(z, self.acting.at(float(z[-1])))
        return np.real(terms.inertial + terms.applied), static_array(self.system, terms)

    def load(self, z: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """Derivative d residual / d factor (n,) where the residual is known."""
        terms = self._terms(z, self.acting.more(float(z[-1])), linearize=False)
        return np.real(terms.inertial + terms.applied) - residual + self._driven_rows(float(z[-1]))

    def padded(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates q padded to n, and [0; lam], of the system's type."""
        found: np.ndarray = np.zeros((2, self.n), self.system.dtype)
        found[0, : self.n_q], found[1, self.n_q :] = z[: self.n_q], z[self.n_q : self.n]
        return found[0], found[1]

    def _terms(self, z: np.ndarray, inputs: Inputs, linearize: bool = True) -> Terms:
        q, acc = self.padded(z)
        return self.system.evaluate(inputs, q, self._rest, acc, linearize=linearize)

    def _driven_rows(self, factor: float) -> np.ndarray:
        """Derivatives - df / d factor in the last row of every driver."""
        rows = np.zeros(self.n)
        if len(self._drivers):
            rows[self._driven] = -self.acting.driven(factor)[self._drivers]
        rows[self.system.plan.dropped] = 0.0
        return rows
