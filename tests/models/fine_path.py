"""The judge of statics: a path of equilibria in hundreds of small steps of equal length, with nothing clever about them.

Its formulas are its own: dense matrices, the load's direction by differences, stability from the eigenvalues of the projected stiffness.
It shares with the toolkit the equations of the scene and the first equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import brentq

from toolkit.solvers.static.equilibrium import inputs_at, static_matrix
from toolkit.solvers.static.static_start import start_of_path
from toolkit.system.system import System

STRAIGHT = 0.996
"""Least cosine between the directions of neighbouring points, 5 degrees."""
NEAR = 0.02
"""Part of a step by which Newton may correct it."""


@dataclass(frozen=True)
class Outcome:
    """How the path goes on: "equilibrium" under the full load, "limit" or "bifurcation" at a load factor, or "end", and the state there."""

    what: str
    factor: float
    q: np.ndarray
    steps: int


class FinePath:
    """Arc-length steps `length` long, where a path that moves by `size` (parts of the model size) to full load has length 1."""

    def __init__(self, system: System, size: float, length: float) -> None:
        self.system, self.options, self.length = system, system.scene.solver, length
        self.n, self.n_q = system.n, system.n_q
        self.metric = np.zeros(self.n + 1)
        self.metric[: self.n_q], self.metric[-1] = (system.weights[: self.n_q] / max(size, 1e-6)) ** 2, 1.0

    def residual(self, z: np.ndarray, factor: float | None = None) -> tuple[np.ndarray, np.ndarray]:
        q, acc = np.zeros(self.n), np.zeros(self.n)
        q[: self.n_q], acc[self.n_q :] = z[: self.n_q], z[self.n_q : -1]
        terms = self.system.evaluate(inputs_at(self.system, self.options, z[-1] if factor is None else factor), q, 0 * q, acc)
        return terms.inertial + terms.applied, self.system.matrix(static_matrix(self.system, terms)).toarray()

    def bordered(self, z: np.ndarray, border: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        residual, matrix = self.residual(z)
        load = (self.residual(z, z[-1] + 1e-4)[0] - self.residual(z, z[-1] - 1e-4)[0]) / 2e-4
        return residual, np.block([[matrix, load[:, None]], [border[None]]])

    def direction(self, z: np.ndarray, border: np.ndarray) -> np.ndarray:
        found = np.linalg.solve(self.bordered(z, border)[1], np.append(np.zeros(self.n), 1.0))
        return found / np.sqrt(self.metric @ found**2)

    def ahead(self, z: np.ndarray, t: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
        """Point and direction at a distance along the direction t."""
        border, predicted = self.metric * t, z + length * t
        found = predicted
        for _ in range(12):
            residual, matrix = self.bordered(found, border)
            change = np.linalg.solve(matrix, -np.append(residual, border @ (found - predicted)))
            found = found + change
            if np.sqrt(self.metric @ change**2) < 1e-11:
                break
        else:
            raise ArithmeticError("no convergence")
        if np.sqrt(self.metric @ (found - predicted) ** 2) > NEAR * length + 1e-10:
            raise ArithmeticError("strayed")
        after = self.direction(found, border)
        if (self.metric * t) @ after < STRAIGHT:
            raise ArithmeticError("turned")
        return found, after

    def negative(self, z: np.ndarray) -> int:
        """Real negative eigenvalues of the stiffness against allowed motions."""
        matrix, w = self.residual(z)[1], self.system.weights[: self.n_q]
        free = null_space(matrix[: self.n_q, self.n_q :].T / w) / w[:, None] if self.n > self.n_q else np.diag(1 / w)
        stiffness = free.T @ matrix[: self.n_q, : self.n_q] @ free
        if np.abs(stiffness - stiffness.T).max(initial=0) < 1e-10 * np.abs(stiffness).max(initial=0):
            return int(np.count_nonzero(np.linalg.eigvalsh(stiffness) < 0))
        values = np.linalg.eigvals(stiffness)
        return int(np.count_nonzero((values.real < 0) & (np.abs(values.imag) <= 1e-9 * np.abs(values))))

    def follow(self, most: int = 20_000) -> Outcome:
        """Up to the full load, or to where the path turns back or loses its stability."""
        state, factor, _ = start_of_path(self.system, self.options)
        z = np.concatenate([state.q[: self.n_q], state.acc[self.n_q :], [factor]])
        t, step = self.direction(z, np.append(np.zeros(self.n), 1.0)), self.length
        for count in range(most):
            try:
                after, t_after = self.ahead(z, t, step)
            except (ArithmeticError, np.linalg.LinAlgError):
                step /= 2
                if step < 1e-8:
                    return Outcome("end", z[-1], z[: self.n_q], count)
                continue
            if t_after[-1] < 0:
                return self._limit(z, t, step, count)
            if after[-1] >= 1:
                return self._full_load(z, t, step, count)
            if self.negative(after):
                return self._bifurcation(z, t, step, count)
            z, t, step = after, t_after, min(self.length, 2 * step)
        raise AssertionError("the judge came to no end")

    def _limit(self, z: np.ndarray, t: np.ndarray, step: float, count: int) -> Outcome:
        place = brentq(lambda s: self.ahead(z, t, s)[1][-1] if s else t[-1], 0, step, xtol=1e-10 * step)
        found = self.ahead(z, t, place)[0] if place else z
        if found[-1] >= 1:
            return self._full_load(z, t, place, count)
        return Outcome("limit", found[-1], found[: self.n_q], count)

    def _full_load(self, z: np.ndarray, t: np.ndarray, step: float, count: int) -> Outcome:
        place = brentq(lambda s: (self.ahead(z, t, s)[0][-1] if s else z[-1]) - 1, 0, step, xtol=1e-12 * step)
        found = self.ahead(z, t, place)[0] if place else z
        if self.negative(found):
            return self._bifurcation(z, t, place, count)
        return Outcome("equilibrium", 1.0, found[: self.n_q], count)

    def _bifurcation(self, z: np.ndarray, t: np.ndarray, step: float, count: int) -> Outcome:
        low, high = 0.0, step
        for _ in range(30):
            middle = (low + high) / 2
            low, high = (low, middle) if self.negative(self.ahead(z, t, middle)[0]) else (middle, high)
        found = self.ahead(z, t, high)[0]
        return Outcome("bifurcation", found[-1], found[: self.n_q], count)
