"""The equations of a path of equilibria, residual(z) = 0 for z = [q; lam; factor]: loads by their factor, bordered matrices, points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import scipy

from toolkit.description.run_options import RunOptions
from toolkit.solvers.static.equilibrium import LEVELS, inputs_at, leading_curves
from toolkit.solvers.static.static_matrix import Softness, StaticArray, balance, static_array
from toolkit.system.equations import Inputs, Terms
from toolkit.system.system import System


class PathLoads(Protocol):
    """Interface of what acts along a path of equilibria, by its factor.

    Everything is linear in the loads, and drivers enter the equations by their values alone.
    """

    def at(self, factor: float) -> Inputs:
        """Inputs of the equations at a factor."""

    def more(self, factor: float) -> Inputs:
        """Inputs with the same drivers, and with loads grown by their derivative by the factor."""

    def driven(self, factor: float) -> np.ndarray:
        """Derivatives d / d factor of the drivers' values, for all time curves (n_curves,)."""


class GrowingLoads:
    """Loads and gravity scaled by the factor, drivers and set values between their first and last value."""

    def __init__(self, system: System, options: RunOptions) -> None:
        self._none, self._full = (inputs_at(system, options, factor) for factor in (0.0, 1.0))
        self._growth = self._full.curves - self._none.curves
        self._leading = leading_curves(system)

    def at(self, factor: float) -> Inputs:
        """Inputs of the equations at a factor."""
        return self._none._replace(curves=self._none.curves + factor * self._growth, scale=float(factor))

    def more(self, factor: float) -> Inputs:
        """Inputs with all loads once more, by which they grow with the factor."""
        found = self.at(factor)
        curves = found.curves  # made for this one
        curves[self._leading] += self._growth[self._leading]
        return found._replace(scale=found.scale + 1.0)

    def driven(self, _factor: float) -> np.ndarray:
        """Derivatives of the drivers' values by the factor: their way from the first to the last value, (n_curves,)."""
        found: np.ndarray = np.real(self._growth)[:, 0]
        return found


class PassingTime:
    """Everything that changes with time, from one time (factor 0) to another (factor 1)."""

    def __init__(self, system: System, first: float, last: float) -> None:
        self._system, self._first, self._span = system, first, last - first
        self._drivers = np.zeros(len(self.at(0.0).curves), bool)
        self._drivers[[c for c in system.plan.joints.curve if c >= 0]] = True

    def at(self, factor: float) -> Inputs:
        """Inputs of the equations at a factor."""
        return self._system.inputs(self._first + factor * self._span, LEVELS)

    def more(self, factor: float) -> Inputs:
        """Inputs with loads grown by their derivative by the factor."""
        found = self.at(factor)
        growth = np.zeros_like(found.curves)
        growth[~self._drivers, 0] = self._span * found.curves[~self._drivers, 1]
        return found._replace(curves=found.curves + growth)

    def driven(self, factor: float) -> np.ndarray:
        """Derivatives of the drivers' values by the factor, (n_curves,)."""
        found: np.ndarray = np.real(self._span * self.at(factor).curves[:, 1])
        return found


class PathEquations:
    """Equations of a path of equilibria of a scene under what acts.

    Of a complex step the path is that of its real design: real parts alone decide where it goes.
    """

    def __init__(self, system: System, options: RunOptions, acting: PathLoads) -> None:
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


TRUSTED_REFINEMENT = 1e-10
"""Refinement of a solution, in parts of it, up to which it is believed: near a limit point the matrix alone is singular."""


@dataclass(frozen=True)
class Bordered:
    """A bordered matrix [A, f; b^T, c], which is factored once."""

    matrix: StaticArray  # A (n, n)
    column: np.ndarray  # f (n,)
    row: np.ndarray  # b (n,)
    corner: float  # c

    def solve(self, rhs: np.ndarray) -> np.ndarray | None:
        """Solution for rhs (n + 1,); None if there is none."""
        if isinstance(self.matrix, np.ndarray):
            return self._by_dense_factors(rhs)
        found = self._by_the_matrix_alone(rhs)
        return self._by_sparse_factors(rhs) if found is None else found

    def _by_dense_factors(self, rhs: np.ndarray) -> np.ndarray | None:
        factors, pivots, info = self._dense_factors
        return None if info else scipy.linalg.lapack.dgetrs(factors, pivots, rhs, trans=1)[0]

    @cached_property
    def _dense_factors(self) -> tuple[np.ndarray, np.ndarray, int]:
        """Factors of the whole matrix, transposed as LAPACK wants it, with pivots, and a number not 0 if it is singular."""
        n = len(self.column)
        full = np.empty((n + 1, n + 1))
        full[:n, :n], full[:n, n], full[n, :n], full[n, n] = self.matrix, self.column, self.row, self.corner
        factors, pivots, info = scipy.linalg.lapack.dgetrf(full.T, overwrite_a=1)
        return factors, pivots, info

    @cached_property
    def _sparse_factors(self) -> scipy.sparse.linalg.SuperLU | None:
        """Sparse factors of A alone; None if it is exactly singular."""
        try:
            return scipy.sparse.linalg.splu(scipy.sparse.csc_array(self.matrix))
        except RuntimeError:
            return None

    def _by_the_matrix_alone(self, rhs: np.ndarray) -> np.ndarray | None:
        """Solution by factors of A alone, refined once; None where A alone is too near to singular."""
        n, factors = len(self.column), self._sparse_factors
        if factors is None:
            return None
        along = factors.solve(self.column)
        rest = self.corner - self.row @ along

        def solved(wanted: np.ndarray) -> np.ndarray:
            inside = factors.solve(wanted[:n])
            last = (wanted[n] - self.row @ inside) / rest
            return np.append(inside - last * along, last)

        with np.errstate(all="ignore"):
            found = solved(rhs)
            change = solved(rhs - self._times(found))
        good = np.all(np.isfinite(change)) and np.abs(change).max() <= TRUSTED_REFINEMENT * np.abs(found).max()
        return found + change if good else None

    def _by_sparse_factors(self, rhs: np.ndarray) -> np.ndarray | None:
        """Solution by sparse factors of the whole matrix, which takes longer; None if it is exactly singular."""
        whole = scipy.sparse.block_array([[self.matrix, self.column[:, None]], [self.row[None], np.array([[self.corner]])]])
        try:
            found: np.ndarray = scipy.sparse.linalg.splu(scipy.sparse.csc_array(whole)).solve(rhs)
        except RuntimeError:
            return None
        return found

    def _times(self, x: np.ndarray) -> np.ndarray:
        inside, last = x[:-1], x[-1]
        return np.append(self.matrix @ inside + self.column * last, self.row @ inside + self.corner * last)


SMALLEST_EXTENT, SMALLEST_EXTENT_PART = 1e-7, 1e-2
"""Least extent of a coordinate that counts, in parts of the model size (or rad), and in parts of that of the one that moves most."""


@dataclass(frozen=True)
class Box:
    """Box that a path has filled: lowest and highest z = [q; lam; factor] (n + 1,), and the weights of coordinates (n_q,)."""

    low: np.ndarray
    high: np.ndarray
    weights: np.ndarray

    @classmethod
    def around(cls, z: np.ndarray, weights: np.ndarray) -> Box:
        """Box that holds one point alone."""
        return cls(z, z, weights)

    def with_point(self, z: np.ndarray) -> Box:
        """Box that holds one point more."""
        return Box(np.minimum(self.low, z), np.maximum(self.high, z), self.weights)

    def measure(self, change: np.ndarray) -> float:
        """Largest part of the box that a change of z (n + 1,) makes up, of a coordinate or of the load."""
        n_q, extent = len(self.weights), self.high - self.low
        moved = float(parts(self.weights * change[:n_q], self.weights * extent[:n_q]))
        return max(moved, abs(float(change[-1])) / extent[-1] if extent[-1] > 0 else 0.0)

    def metric(self) -> np.ndarray:
        """Diagonal (n + 1,) of the metric of arc length in which the box is as long in the coordinates as in the load."""
        n_q, extent = len(self.weights), self.high - self.low
        found = np.zeros(len(self.low))
        length = np.linalg.norm(self.weights * extent[:n_q])
        found[:n_q] = (self.weights / max(length, SMALLEST_EXTENT)) ** 2
        found[-1] = 1 / extent[-1] ** 2
        return found


def parts(change: np.ndarray, extent: np.ndarray) -> np.ndarray:
    """Largest part of a box that changes of weighted coordinates (..., n_q) make up.

    Where the model size (or rad) is larger than the box, it is compared with that.
    """
    least = np.clip(SMALLEST_EXTENT_PART * extent.max(axis=-1, initial=0, keepdims=True), SMALLEST_EXTENT, SMALLEST_EXTENT_PART)
    found: np.ndarray = (np.abs(change) / np.clip(extent, least, 1.0)).max(axis=-1, initial=0)
    return found


@dataclass(frozen=True)
class PathPoint:
    """An equilibrium z = [q; lam; factor] (n + 1,) on a path, with its direction and its stability.

    direction : dz along the path, of any length (n + 1,)
    negative : number of negative stiffnesses against motions that the joints allow
    soft : the stiffnesses nearest to zero
    softening : their change along the direction
    """

    z: np.ndarray
    direction: np.ndarray
    negative: int
    soft: Softness
    softening: np.ndarray

    @property
    def factor(self) -> float:
        """Load factor of the point."""
        return float(self.z[-1])

    @property
    def rate(self) -> float:
        """Change d factor along the direction, whose sign changes at a limit point."""
        return float(self.direction[-1])
