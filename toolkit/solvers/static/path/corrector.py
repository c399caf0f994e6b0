"""Newton's iteration across a path of equilibria, from a predicted point to the path, and all that is known of the point found."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.foundation.errors import ConvergenceError
from toolkit.solvers.static.path.bordered import Bordered
from toolkit.solvers.static.path.path_equations import PathEquations
from toolkit.solvers.static.path.path_point import PathPoint
from toolkit.solvers.static.stability.saddle import balanced, factorised, free_count
from toolkit.solvers.static.stability.softness import softest
from toolkit.solvers.static.stability.static_array import StaticArray

ROUND_OFF = 1e-13
"""Correction below which nothing is left to gain; one that no longer halves has met round-off above it."""
QUADRATIC = 0.1
"""Contraction from which the next correction is known well enough: its square."""
CLOSE = 1e-4
"""Part of the way to another point at which the change of the stiffness is taken."""


class Crossing(NamedTuple):
    """[A, f; b^T] of a path and a plane across it, in coordinates of comparable size."""

    bordered: Bordered
    scale: np.ndarray  # (n,) of the unknowns
    wide: float  # of the column f
    high: float  # of the row b

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Solution x (n + 1,) of [A, f; b^T] x = rhs.

        Raises
        ------
        ConvergenceError
            There is no such x, or more than one.
        """
        n, scale = len(self.scale), self.scale
        found = self.bordered.solve(_joined(scale * rhs[:n], rhs[n] / self.high))
        if found is None or not np.all(np.isfinite(found)):
            raise ConvergenceError("the path has no single direction here")
        return _joined(scale * found[:n], found[n] / self.wide)

    def ahead(self) -> np.ndarray:
        """Direction t (n + 1,) of the path, [A, f; b^T] t = [0; 1]; errors as `solve`."""
        return self.solve(_joined(np.zeros(len(self.scale)), 1.0))


def _joined(many: np.ndarray, last: float) -> np.ndarray:
    """Vector [many; last] (n + 1,), sooner than numpy's `append` for the few of a small scene."""
    found = np.empty(len(many) + 1)
    found[:-1], found[-1] = many, last
    return found


class Corrected(NamedTuple):
    """A point of the path z (n + 1,), the static matrix (n, n) there, also with the plane's border, and Newton's iterations."""

    z: np.ndarray
    matrix: StaticArray
    crossing: Crossing
    iterations: int


def correct(
    equations: PathEquations, border: np.ndarray, predicted: np.ndarray, allowed: float, exact: bool = False
) -> Corrected:
    """Equilibrium in the plane across the path through a predicted point.

        residual(z) = 0,   b^T (z - z_predicted) = 0,   z = [q; lam; factor]

    With b along the path this is pseudo-arc-length continuation (Keller 1977; as Riks 1979), whose matrix [K, residual_f; b^T] is regular
    at limit points too. Newton may move the point by `allowed` parts of the model size, rad or the load. It stops where the next
    correction would be below the tolerance, if `exact` at round-off; the matrix is that of the point before the last correction.

    Raises
    ------
    ConvergenceError
        Newton strays, or does not converge.
    """
    system, options = equations.system, equations.options
    z, size = predicted, np.inf
    for iteration in range(1, options.max_iterations + 1):
        residual, matrix = equations.linearised(z)
        crossing = crossed(equations, matrix, equations.load(z, residual), border)
        correction = crossing.solve(_joined(residual, border @ (z - predicted)))
        z = z - correction
        before, size = size, measure(equations, correction)
        if not np.isfinite(size) or measure(equations, z - predicted) > allowed + options.tolerance:
            raise ConvergenceError(f"Newton strays from the path at {system.most_moved(correction)}")
        left = size if exact or iteration == 1 or size > QUADRATIC * before else size * size / before
        if left <= options.tolerance and (not exact or size > 0.5 * before or size <= ROUND_OFF):
            return Corrected(z, matrix, crossing, iteration)
    raise ConvergenceError(f"Newton did not converge in {options.max_iterations} iterations: correction {size:.1e}")


def crossed(equations: PathEquations, matrix: StaticArray, load: np.ndarray, border: np.ndarray) -> Crossing:
    """Crossing of the path and a plane with normal `border` (n + 1,).

    The static matrix A (n, n) and d residual / d factor f (n,) are known there.
    """
    n, scale = equations.n, equations.scale
    column, row, corner = scale * load, border[:n] * scale, border[n]
    wide = max(np.abs(column).max(initial=0), abs(corner)) or 1.0
    high = max(np.abs(row).max(initial=0), abs(corner / wide))
    bordered = Bordered(balanced(equations.system, matrix, scale), column / wide, row / high, corner / wide / high)
    return Crossing(bordered, scale, wide, high)


def first_point(equations: PathEquations, z: np.ndarray) -> PathPoint:
    """Equilibrium z = [q; lam; factor] as the beginning of a path on which the factor grows."""
    equations.begin(z)
    residual, matrix = equations.linearised(z)
    border = _joined(np.zeros(equations.n), 1.0)
    crossing = crossed(equations, matrix, equations.load(z, residual), border)
    return complete(equations, Corrected(z, matrix, crossing, 0), None)


def complete(equations: PathEquations, found: Corrected, known: PathPoint | None) -> PathPoint:
    """Point with the direction of the path and its stability; `known` is a point near by."""
    system, direction = equations.system, found.crossing.ahead()
    saddle = factorised(system, found.matrix, equations.scale, found.crossing.bordered.matrix)
    soft = softest(saddle, free_count(system), system.n_b, known.soft if known else None)
    ahead = CLOSE / max(measure(equations, direction), CLOSE)
    difference = equations.linearised(found.z + ahead * direction)[1] - equations.linearised(found.z)[1]
    return PathPoint(found.z, direction, saddle.negative, soft, soft.change(difference) / ahead)


def measure(equations: PathEquations, change: np.ndarray) -> float:
    """Largest change of a coordinate or of the load factor in [q; lam; factor], in parts of the model size, rad, or the load."""
    n_b = equations.system.n_b
    moved = np.abs(equations.system.weights[:n_b] * change[:n_b])
    return max(float(moved.max(initial=0)), abs(float(change[-1])))
