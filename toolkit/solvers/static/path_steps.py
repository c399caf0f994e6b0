"""Steps along a path of equilibria, predicted and corrected, that pass no limit point and no bifurcation unseen.

A step is accepted where everything that is known of the path agrees on what lies between its ends:

* its end is where the cubic through the last two points and their directions predicts it, and so is the direction there; all coordinates
  and the load are measured by the box that the path has filled so far, so that a snap of a thousandth of that is seen;
* the number of negative stiffnesses changes by one where the load turns back, and not at all where it goes on;
* the cubic between the ends shows no two limit points, and no stiffness that vanishes and comes back.

Otherwise it is shortened. Only a change of stability that no step is too short for is a bifurcation.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from toolkit.foundation.errors import ConvergenceError, SingularSystemError
from toolkit.solvers.static.path_equations import Bordered, Box, PathEquations, PathPoint
from toolkit.solvers.static.static_matrix import StaticArray, balanced, factorised, free_count, softest

ROUND_OFF = 1e-13
"""Correction below which nothing is left to gain; one that no longer halves has met round-off above it."""
QUADRATIC_CONTRACTION = 0.1
"""Contraction from which the next correction is known well enough: its square."""
SECANT_PART = 1e-4
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
        left = size if exact or iteration == 1 or size > QUADRATIC_CONTRACTION * before else size * size / before
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
    ahead = SECANT_PART / max(measure(equations, direction), SECANT_PART)
    difference = equations.linearised(found.z + ahead * direction)[1] - equations.linearised(found.z)[1]
    return PathPoint(found.z, direction, saddle.negative, soft, soft.change(difference) / ahead)


def measure(equations: PathEquations, change: np.ndarray) -> float:
    """Largest change of a coordinate or of the load factor in [q; lam; factor], in parts of the model size, rad, or the load."""
    n_b = equations.system.n_b
    moved = np.abs(equations.system.weights[:n_b] * change[:n_b])
    return max(float(moved.max(initial=0)), abs(float(change[-1])))


class Cubic(NamedTuple):
    """A cubic z(p) with z(0), z'(0), z(length), z'(length) given, each (n,) (Hermite's interpolation).

    It is good a little beyond its ends too.
    """

    begin: np.ndarray
    begin_slope: np.ndarray
    end: np.ndarray
    end_slope: np.ndarray
    length: float

    def at(self, p: float) -> np.ndarray:
        """Value z(p) of the cubic."""
        x = p / self.length
        values = (1 + 2 * x) * (1 - x) ** 2 * self.begin + x**2 * (3 - 2 * x) * self.end
        found: np.ndarray = values + self.length * x * (1 - x) * ((1 - x) * self.begin_slope - x * self.end_slope)
        return found

    def slope(self, p: float) -> np.ndarray:
        """Slope z'(p) of the cubic."""
        x = p / self.length
        found: np.ndarray = (
            6 * x * (1 - x) * (self.end - self.begin) / self.length
            + (1 - x) * (1 - 3 * x) * self.begin_slope
            + x * (3 * x - 2) * self.end_slope
        )
        return found


PREDICTION_MISS, FIRST_PREDICTION_MISS = 5e-3, 1e-2
"""Parts of the box by which a step may end elsewhere than predicted by a cubic; and the first one than its two directions say."""
SUSPECT_PREDICTION = 10 * PREDICTION_MISS
"""Error of the second step's prediction that casts doubt on the first."""
LEAST_LOAD_SHARE = 0.3
"""Least part of the load in the direction of the step that ends under the full load; others have a given length."""
LENGTH_TOLERANCE = 1e-3
"""Part of its length by which that step may be longer than others."""
SHORTEST_STEP, RESOLVED_STEP = 1e-7, 1e-4
"""Parts of the box: the shortest step, and one in which nothing hides."""
LEAST_TURN_COSINE = 0.8
"""Least cosine between the directions at both ends of a step of given length."""
LARGEST_END_CORRECTION = 0.2
"""Part of a step by which Newton may correct its end."""
LARGEST_GROWTH, SMALLEST_SHRINKING, USUAL_SHRINKING = 2.0, 0.125, 0.5
"""Largest ratio of a step's length to that of the last; smallest and usual part of a rejected length."""


class Arc(NamedTuple):
    """A step along the path: the plane b^T (z - z_begin) = length holds its end, and b^T t = 1 for the slopes of `cubic` at both ends.

    A `branching` one is too short to tell why the stability changes in it: another path crosses.
    """

    begin: PathPoint
    end: PathPoint
    border: np.ndarray
    length: float
    iterations: int
    growth: float  # of the next step
    part: float  # of the box
    branching: bool

    @property
    def cubic(self) -> Cubic:
        """Cubic between the two ends of the step."""
        first, last = (point.direction / (self.border @ point.direction) for point in (self.begin, self.end))
        return Cubic(self.begin.z, first, self.end.z, last, self.length)

    @property
    def turns(self) -> bool:
        """Whether the load turns back within the step."""
        cubic = self.cubic
        return bool((cubic.begin_slope[-1] > 0) != (cubic.end_slope[-1] > 0))


class StepPlan(NamedTuple):
    """A step to be tried: its plane, its direction with b^T t = 1, and its length; also in parts of the box."""

    border: np.ndarray
    slope: np.ndarray
    length: float
    part: float


class _TooLong(ConvergenceError):
    """A step that does not show what lies in it.

    It holds the part of its length that is to be tried, and how far the step ends from its prediction.
    """

    def __init__(self, why: str, part: float = USUAL_SHRINKING, error: float = 0.0) -> None:
        super().__init__(why)
        self.part, self.error = min(max(part, SMALLEST_SHRINKING), USUAL_SHRINKING), error


class _Doubt(ConvergenceError):
    """A second step that says that the first was too long."""


def arcs(equations: PathEquations, start: PathPoint, most: float) -> Iterator[Arc]:
    """Follow the path without end, in steps of at most a part `most` of the load.

    Raises
    ------
    ConvergenceError
        The path ends: something moves or grows beyond all bounds, or branches meet.
    """
    last, length, empty = None, np.inf, Box.around(start.z, equations.system.weights[: equations.system.n_b])
    while last is None:
        first = _step(equations, empty, start, None, most, length)
        box = empty.with_point(first.end.z)
        try:
            last = _step(equations, box, first.end, first, most, doubtful=first.part > RESOLVED_STEP)
        except _Doubt:
            length = USUAL_SHRINKING * first.length
        except ConvergenceError:
            yield first
            raise
    yield first
    while True:
        yield last
        box = box.with_point(last.end.z)
        last = _step(equations, box, last.end, last, most)


def _step(
    equations: PathEquations,
    box: Box,
    begin: PathPoint,
    before: Arc | None,
    most: float,
    length: float = np.inf,
    doubtful: bool = False,
) -> Arc:
    """Longest step that is accepted: at most `length`, and at most a part `most` of the load; the one before may be doubtful."""
    while True:
        plan = _plan(box, begin, before, most, length)
        try:
            return _attempt(equations, box, begin, before, plan)
        except (ConvergenceError, SingularSystemError) as error:
            if plan.part < SHORTEST_STEP:
                raise (_nothing_near(error) if before is None else _lost(begin.factor, error)) from error
            if doubtful and isinstance(error, _TooLong) and error.error > SUSPECT_PREDICTION:
                raise _Doubt(str(error)) from error
            length = plan.length * (error.part if isinstance(error, _TooLong) else USUAL_SHRINKING)


def _plan(box: Box, begin: PathPoint, before: Arc | None, most: float, length: float) -> StepPlan:
    """Plan of the next step.

    It has the given length by the metric of the box, or leads to the full load where that is near and grows well.
    """
    direction = begin.direction
    if before is None:
        box = box.with_point(begin.z + most / abs(begin.rate) * direction)
    metric = box.metric()
    size = np.sqrt(metric @ direction**2)
    slope = direction / size
    border = metric * slope
    if before is not None:
        length = min(length, before.growth * abs(border @ (before.begin.z - begin.z)))
    length = min(length, most / max(abs(slope[-1]), most * SHORTEST_STEP))
    plan = StepPlan(border, slope, length, length)
    missing = (1 - begin.factor) / slope[-1] if slope[-1] * np.sqrt(metric[-1]) > LEAST_LOAD_SHARE else np.inf
    if 0 < missing <= length * (1 + LENGTH_TOLERANCE):
        return plan._replace(
            border=np.append(0 * border[1:], 1.0), slope=direction / begin.rate, length=1 - begin.factor, part=missing
        )
    return plan


def _attempt(equations: PathEquations, box: Box, begin: PathPoint, before: Arc | None, plan: StepPlan) -> Arc:
    """Result of one step along the path.

    Raises
    ------
    ConvergenceError, SingularSystemError
        Newton finds no equilibrium there.
    """
    known = _known(plan.border, before)
    predicted = known.at(known.length + plan.length) if known else begin.z + plan.length * plan.slope
    predicted = predicted + (plan.length - plan.border @ (predicted - begin.z)) * plan.slope  # in the plane, to round-off
    reach = LARGEST_END_CORRECTION * max(measure(equations, plan.length * plan.slope), measure(equations, predicted - begin.z))
    found = correct(equations, plan.border, predicted, reach)
    box = box.with_point(found.z)
    error = box.measure(found.z - predicted) if known else 0.0
    if error > PREDICTION_MISS:
        raise _TooLong("the path bends too sharply", 0.9 * (PREDICTION_MISS / error) ** 0.25, error)
    end = complete(equations, found, begin)
    arc = Arc(begin, end, plan.border, plan.length, found.iterations, _growth(error), plan.part, False)
    _check_directions(box, arc, known)
    if _stability_fits(arc):
        _check_between(box, arc, error)
    elif plan.part < SHORTEST_STEP:
        return arc._replace(branching=True)
    else:
        raise _TooLong("the stability changes without a limit point")
    return arc


def _known(border: np.ndarray, before: Arc | None) -> Cubic | None:
    """Last step as a cubic of the distance across the planes of the next one."""
    if before is None:
        return None
    slopes = [point.direction / (border @ point.direction) for point in (before.begin, before.end)]
    length = border @ (before.end.z - before.begin.z)
    forwards = all(border @ point.direction > 0 for point in (before.begin, before.end))
    return Cubic(before.begin.z, slopes[0], before.end.z, slopes[1], float(length)) if forwards and length > 0 else None


def _growth(error: float) -> float:
    """Factor of the next step's length, which makes its error half of what is allowed.

    Errors go as the fourth power of a step.
    """
    return float(np.clip((PREDICTION_MISS / 2 / max(error, 1e-300)) ** 0.25, USUAL_SHRINKING, LARGEST_GROWTH))


def _check_directions(box: Box, arc: Arc, known: Cubic | None) -> None:
    """Check that the direction at the end is the predicted one, and that it does not turn far.

    The first step has to be what its two directions say.
    """
    cubic = arc.cubic
    if known is None:
        error = box.measure(cubic.end - cubic.begin - arc.length / 2 * (cubic.begin_slope + cubic.end_slope))
        if error > FIRST_PREDICTION_MISS:
            raise _TooLong("the path bends too sharply", 0.9 * (FIRST_PREDICTION_MISS / error) ** (1 / 3))
        return
    error = box.measure(arc.length * (cubic.end_slope - known.slope(known.length + arc.length)))
    if error > 5 * PREDICTION_MISS:
        raise _TooLong("the path turns too sharply", 0.9 * (5 * PREDICTION_MISS / error) ** 0.25, error)
    metric = box.metric()
    sizes = [np.sqrt(metric @ slope**2) for slope in (cubic.begin_slope, cubic.end_slope)]
    if (cubic.begin_slope * metric) @ cubic.end_slope < LEAST_TURN_COSINE * sizes[0] * sizes[1]:
        raise _TooLong("the path turns too sharply")


def _stability_fits(arc: Arc) -> bool:
    """Whether one motion loses or gains its stability where the load turns back, and none where it goes on."""
    return abs(arc.end.negative - arc.begin.negative) == int(arc.turns)


def _check_between(box: Box, arc: Arc, error: float) -> None:
    """Check that no two limit points, and no stiffness that vanishes and comes back, lie between the ends.

    They are looked for by what the ends show.
    """
    if arc.turns or arc.part < RESOLVED_STEP:
        return
    cubic = arc.cubic
    begin, begin_slope, end, end_slope = (each[-1:] for each in (cubic.begin, cubic.begin_slope, cubic.end, cubic.end_slope))
    load = Cubic(begin, begin_slope, end, end_slope, cubic.length)
    slopes = [load.slope(p)[0] for p in np.linspace(0, arc.length, 9)]
    ends = min(abs(slopes[0]), abs(slopes[-1]))
    margin = 4 * error * (box.high[-1] - box.low[-1]) / arc.length
    if min(np.array(slopes) * np.sign(slopes[0])) < min(margin, 0.9 * ends):
        raise _TooLong("the load nearly turns back")
    for low, falling, high, rising in _softening(arc):
        if low > 0 < high and falling < 0 < rising:
            place = (high - rising * arc.length - low) / (falling - rising)
            if low + falling * place <= 0:
                raise _TooLong("a stiffness nearly vanishes")


def _softening(arc: Arc) -> Iterator[tuple[float, float, float, float]]:
    """Value and slope of the softest stiffnesses at both ends."""
    begin, end = arc.begin, arc.end
    scales = (arc.border @ begin.direction, arc.border @ end.direction)
    for k in range(min(len(begin.soft.values), len(end.soft.values))):
        yield begin.soft.values[k], begin.softening[k] / scales[0], end.soft.values[k], end.softening[k] / scales[1]


def _nothing_near(error: Exception) -> ConvergenceError:
    return ConvergenceError(
        f"statics finds no equilibrium near the undeformed state, even under the smallest part of the load ({error}). "
        "The loads may be far too large for the supports; look for one that is orders of magnitude off, or a wrong unit."
    )


def _lost(factor: float, error: Exception) -> ConvergenceError:
    return ConvergenceError(
        f"the static path ends at {100 * factor:.6g} % of the load ({error}), and no limit point was found there: a singular "
        "position, branches that meet, or round-off of parts too stiff for solver.tolerance. A transient run can go on from there; a "
        "smaller load stays below it."
    )
