"""Arc-length continuation: the path of equilibria by its own length, so that the load may turn back at limit points."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.sparse import bmat, csc_array
from scipy.sparse.linalg import splu

from toolkit.errors import ConvergenceError
from toolkit.run_options import RunOptions
from toolkit.solvers.equilibrium import inputs_at, static_matrix
from toolkit.system import System

LONGEST, SHORTEST = 0.2, 1e-9
"""Arc steps, in parts of the scene's size, rad, or parts of the load."""
STRAIGHT = 0.95
"""Least cosine between tangents one step apart: a step that turns further (18 degrees) could have met another branch."""
TRUSTED_CORRECTION = 0.2
"""Part of the step by which Newton may correct the predictor: tan(18 degrees) / 2 and a little more."""
FAST, GROWTH = 5, 1.6
"""After so few Newton iterations the next step is longer by this ratio."""
ROUND_OFF = 1e-13
"""Correction below which nothing is left to gain; one that no longer halves has met round-off above it."""
LOAD_DIFFERENCE = 1e-3
"""Change of the load factor for d residual / d factor: exact but for the turning axis of a driver, there to a part of 1e-7."""


class PathPoint(NamedTuple):
    """An equilibrium on the path: coordinates padded to n, [0; lam], load factor, and the path's direction (n + 1,).

    The direction is d [q; lam; factor] / ds, ds^2 = sum (w_i dq_i)^2 + dfactor^2, with the weights w of the scene.
    """

    q: np.ndarray
    acc: np.ndarray
    factor: float
    direction: np.ndarray

    @property
    def rate(self) -> float:
        """d factor / ds, whose sign changes at a limit point."""
        return float(self.direction[-1])


class Arc(NamedTuple):
    """One accepted step: where it began, its length and where it ended, with the Newton iterations that it took."""

    begin: PathPoint
    length: float
    end: PathPoint
    iterations: int


def first_point(system: System, q: np.ndarray, acc: np.ndarray, factor: float, tangent: np.ndarray) -> PathPoint:
    """A point of the path from an equilibrium and its d [q; lam] / d factor; the load grows."""
    direction = np.append(np.real(tangent), 1.0)
    return PathPoint(np.real(q), np.real(acc), factor, direction / np.sqrt(_border(system, direction) @ direction))


def arcs(system: System, options: RunOptions, point: PathPoint, length: float) -> Iterator[Arc]:
    """Follow the path without end, in steps that adapt to its curvature; `length` is that of the first.

    Raises
    ------
    ConvergenceError
        The path ends: something moves or grows beyond all bounds, or branches meet.
    """
    length = min(length, LONGEST)
    while True:
        try:
            end, iterations = advance(system, options, point, length)
            if _border(system, point.direction) @ end.direction < STRAIGHT:
                raise ConvergenceError("the path turns too sharply")
        except ConvergenceError as error:
            length /= 2
            if length < SHORTEST:
                raise ConvergenceError(
                    f"the path of equilibria ends at {100 * point.factor:.6g} % of the load ({error})"
                ) from error
            continue
        yield Arc(point, length, end, iterations)
        point, length = end, min(LONGEST, length * (GROWTH if iterations <= FAST else 1.0))


def advance(system: System, options: RunOptions, point: PathPoint, length: float) -> tuple[PathPoint, int]:
    """The equilibrium z in the plane across the path, at a distance s along the tangent t_0 of a point z_0; Newton iterations.

        residual(z) = 0,   t_0^T W (z - z_0 - s t_0) = 0,   z = [q; lam; factor],   W = diag(w^2, 0, 1)

    This is pseudo-arc-length continuation (Keller 1977; as Riks 1979). Its matrix [K, residual_f; t_0^T W] is regular at limit points.

    Raises
    ------
    ConvergenceError
        Newton strays, or does not converge.
    """
    n_q, border = system.n_q, _border(system, point.direction)
    start = np.concatenate([point.q[:n_q], point.acc[n_q:], [point.factor]])
    predicted = start + length * point.direction
    unknowns, size = predicted, np.inf
    for iterations in range(1, options.max_iterations + 1):
        residual, matrix = linearised(system, options, unknowns)
        gap = border @ (unknowns - predicted)
        correction = _solve_bordered(matrix, border, np.append(residual, gap))
        unknowns = unknowns - correction
        before, size = size, measure(system, correction)
        if not np.isfinite(size) or measure(system, unknowns - predicted) > TRUSTED_CORRECTION * length + options.tolerance:
            raise ConvergenceError(f"Newton strays from the path at {system.most_moved(correction)}")
        if size <= options.tolerance and (size > 0.5 * before or size <= ROUND_OFF):
            return _with_direction(system, options, unknowns, border), iterations
    raise ConvergenceError(f"Newton did not converge in {options.max_iterations} iterations: correction {size:.1e}")


def _with_direction(system: System, options: RunOptions, unknowns: np.ndarray, border: np.ndarray) -> PathPoint:
    """[K, residual_f; t_0^T W] t = [0; 1], scaled to length one: the path goes on in the sense of t_0."""
    ahead = np.append(np.zeros(system.n), 1.0)
    direction = _solve_bordered(linearised(system, options, unknowns)[1], border, ahead)
    direction = direction / np.sqrt(_border(system, direction) @ direction)
    return PathPoint(*padded(system, unknowns), float(unknowns[-1]), direction)


def linearised(system: System, options: RunOptions, unknowns: np.ndarray) -> tuple[np.ndarray, csc_array]:
    """Residual (n,) and its derivative by [q; lam; factor], (n, n + 1)."""
    (q, acc), factor = padded(system, unknowns), unknowns[-1]
    residual, stiffness = _residual(system, options, q, acc, factor)
    high, low = (_residual(system, options, q, acc, factor + side * LOAD_DIFFERENCE)[0] for side in (1, -1))
    return residual, csc_array(bmat([[stiffness, (high - low)[:, None] / (2 * LOAD_DIFFERENCE)]]))


def padded(system: System, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """q padded to n, and [0; lam], from [q; lam; ...]."""
    of_q = np.arange(system.n) < system.n_q
    return np.where(of_q, unknowns[: system.n], 0.0), np.where(of_q, 0.0, unknowns[: system.n])


def measure(system: System, change: np.ndarray) -> float:
    """Largest change of a coordinate or of the load factor in [q; lam; factor], in parts of the scene's size, rad, or the load."""
    moved = np.abs(system.weights[: system.n_q] * change[: system.n_q])
    return max(float(moved.max(initial=0)), abs(float(change[-1])))


def _residual(system: System, options: RunOptions, q: np.ndarray, acc: np.ndarray, factor: float) -> tuple[np.ndarray, csc_array]:
    """Real parts alone: the path of a complex step is that of its real design, until its end is corrected."""
    q, acc = q.astype(system.dtype), acc.astype(system.dtype)
    terms = system.evaluate(inputs_at(system, options, factor), q, np.zeros_like(q), acc)
    return np.real(terms.inertial + terms.applied), np.real(system.matrix(static_matrix(system, terms)))


def _border(system: System, direction: np.ndarray) -> np.ndarray:
    """W t, (n + 1,)."""
    of_q = np.arange(system.n) < system.n_q
    return np.append(np.where(of_q, system.weights**2, 0.0), 1.0) * direction


def _solve_bordered(matrix: csc_array, border: np.ndarray, rhs: np.ndarray) -> np.ndarray:
    full = csc_array(bmat([[matrix], [border[None]]]))
    try:
        found: np.ndarray = splu(full).solve(rhs)
    except RuntimeError as error:
        raise ConvergenceError(f"the path has no single direction here ({error})") from error
    return found
