"""One design solved in all cases: values and gradients, or the reason why there are none.

Norms of gradients as responses: the largest change of a response per step of a design, in scaled variables.

With scales S, the norm N of the gradient g in scaled variables and its derivative are

    N = |S g|,    dN/dz = S H S e,    e = S g / N

H e is the derivative of the gradient along one direction: that of exact gradients at four designs beside, by differences whose error is
known from two steps.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from toolkit.analyses.modes import solve_modes
from toolkit.analyses.sensitivity.direct import evaluated, values_alone
from toolkit.analyses.sensitivity.methods import by_method
from toolkit.analyses.statics import solve_statics
from toolkit.foundation.errors import InputError, NoLimitPointError, ToolkitError
from toolkit.foundation.processes import one_thread
from toolkit.responses.least_frequency import LoadMargin
from toolkit.responses.pencil import pencil_of
from toolkit.responses.vibration import Frequency
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.scene import Scene
from toolkit.studies.problem import Problem
from toolkit.studies.store import EMPTY, DesignOutcome, JobState
from toolkit.system.solution import Solution
from toolkit.system.system import System

SAME_MODE_ASSURANCE = 0.5
"""Assurance above which a mode is the one."""
FREQUENCY_AGREEMENT = 1e-6
"""Relative difference of a frequency by the two ways in which it is found."""


class LostModeError(ToolkitError, ArithmeticError):
    """No mode of a design is the one that is followed."""


def shapes_of(solution: Solution, count: int) -> np.ndarray:
    """The slowest modes of the scene as it stands, (n_q, count).

    Raises
    ------
    InputError
        There are not so many.
    """
    found = solve_modes(solution)
    if len(found.frequencies) < count:
        raise InputError(f"frequency_{count}: the scene has {len(found.frequencies)} modes. Ask for one of these.")
    return found.shapes[:, :count]


def followed(solution: Solution, shapes: np.ndarray, number: int) -> Frequency:
    """The frequency of the mode of an equilibrium that is most like that of a number among the shapes.

    Raises
    ------
    LostModeError
        None of them is like it any more.
    """
    mass = np.real(pencil_of(solution).mass[: solution.system.n_q, : solution.system.n_q])
    modes, reference = solve_modes(solution), shapes[:, number - 1]
    squares = np.real(np.einsum("ik,ij,jk->k", modes.shapes.conj(), mass, modes.shapes))  # complex are those that flutter
    alike = np.abs(reference.conj() @ mass @ modes.shapes) ** 2 / (squares * np.real(reference.conj() @ mass @ reference))
    k = int(np.argmax(alike))
    remedy = f'ask for frequencies by their order, with a response {{ type = "frequency", number = {number} }}'
    if alike[k] <= SAME_MODE_ASSURANCE:
        raise LostModeError(
            f"frequency_{number}: no mode is like the one that has this number where the scene stands. Number {k + 1} is most like it, "
            f"with an assurance of {alike[k]:.2g}, and more than {SAME_MODE_ASSURANCE:g} is wanted. Narrow the bounds, or {remedy}."
        )
    found, value = Frequency(number=k + 1), float(modes.frequencies[k])
    if abs(float(np.real(found.value(solution))) - value) > FREQUENCY_AGREEMENT * abs(value):
        raise LostModeError(
            f"frequency_{number}: modes without stiffness cannot be told from others. Hold what moves freely, or {remedy}."
        )
    return found


class CaseResult(NamedTuple):
    """Values (asked,) and gradients (asked, n) of a case, nan if these were not wanted; the solution; and second derivatives of what the
    problem calls `squares`, (squares, n, n), none if they were not wanted."""

    values: np.ndarray
    gradients: np.ndarray
    solution: Solution
    curvatures: np.ndarray


@dataclass(frozen=True)
class CaseRun:
    """Runs of one case.

    Attributes
    ----------
    problem
        The checked study.
    case
        Name of the case.
    start
        The equilibrium that statics begins in; None begins in the unloaded state.
    gradients
        Whether they are wanted.
    curvatures
        Whether second derivatives of mean squares are wanted too.
    """

    problem: Problem
    case: str
    start: JobState | None
    gradients: bool
    curvatures: bool = False

    def at(self, design: np.ndarray, point: int = 0) -> CaseResult:
        """What the problem asks for, at a design (n,) and a point of the uncertain numbers: the first is that of all means."""
        problem, points = self.problem, self.problem.points
        own = points.at(point) if points else {}
        there = design + points.shifts[point] if points else design
        compiled = problem.compiled.at({**problem.cases[self.case], **own, **problem.numbers(there)})
        if problem.kind == "transient":
            method = problem.study.search.gradients
            result = (
                by_method(method, compiled, "transient", None, False) if self.gradients else values_alone(compiled, "transient")
            )
        else:
            known = None if self.start is None else resting(compiled.primal.scene.solver.end_time, compiled.full, self.start)
            result = evaluated(solve_statics(compiled.full if self.gradients else compiled.primal, start=known), self.gradients)
        values, none = dict(result.values), np.full(len(design), math.nan)
        rows = {name: np.array([each[x] for x in problem.variables]) for name, each in result.gradients.items()}
        for name, each in frequencies(problem, self.case, result.solution).items():
            values[name], rows[name] = each.evaluate(result.solution)
        slopes = [rows[name] if self.gradients else none for name in problem.asked]
        curved = [each.curvature(result.solution) for each in problem.squares.values()] if self.curvatures else []
        return CaseResult(np.array([values[name] for name in problem.asked]), np.array(slopes), result.solution, np.array(curved))


def frequencies(problem: Problem, case: str, solution: Solution) -> dict[str, Frequency]:
    """Frequencies of an equilibrium that are followed by the shapes of their modes."""
    if problem.modes and case not in problem.shapes:
        here = solve_statics(problem.compiled.at(problem.cases[case]).primal)
        problem.shapes[case] = shapes_of(here, max(problem.modes.values()))
    return {name: followed(solution, problem.shapes[case], number) for name, number in problem.modes.items()}


def resting(time_of: float, system: System, state: JobState) -> Solution:
    """A kept equilibrium, as statics takes it for a start."""
    q, lam = state.q[None], state.multipliers[None]
    empty = np.zeros((1, len(state.q), 0))
    none = np.zeros_like(q)
    return Solution(
        system, np.array([time_of]), q, none, none, lam, empty, empty, empty, np.zeros((1, len(state.multipliers), 0))
    )


STEP = 1e-3
"""Step of the differences, relative to the variables' scales: round-off of gradients over it is below 1e-7, as is step^4."""
KINKED_GRADIENT = 1e-2
"""Relative error of a derivative above which the gradient is said to have kinks."""


class DerivedValue(NamedTuple):
    """A value that follows from several runs, with its derivatives by the variables (n,).

    Their error is relative to the largest of them; second derivatives are (n, n), None if these are not known.
    """

    value: float
    slope: np.ndarray
    error: float = 0.0
    curvature: np.ndarray | None = None


def norms(run: CaseRun, design: np.ndarray, here: CaseResult) -> Iterator[DerivedValue]:
    """Norms of the gradients of all responses for which a norm is asked; `here` is the run at the design, with gradients.

    Raises
    ------
    ToolkitError
        A design beside cannot be solved, or the gradient leaps.
    """
    for name in run.problem.norms:
        yield _norm(run, design, here, run.problem.asked.index(name))


def with_gradients(run: CaseRun) -> CaseRun:
    """The run with gradients, if a norm of one is asked for; otherwise the run as it is."""
    return replace(run, gradients=True) if run.problem.norms else run


def _norm(run: CaseRun, design: np.ndarray, here: CaseResult, place: int) -> DerivedValue:
    problem, scales = run.problem, run.problem.scales
    slope = scales * here.gradients[place]
    value = float(np.sqrt(np.sum(slope**2)))
    if value <= problem.undecided(problem.asked[place], here.values[place : place + 1]):
        return DerivedValue(value, np.zeros_like(slope))  # it can only grow from here
    along = scales * slope / value
    far, near = (_difference(run, design, step, along, place) for step in (2 * STEP, STEP))
    second = scales * (4 * near - far) / 3
    size = float(np.max(np.abs(second)))
    error = float(np.max(np.abs(scales * (near - far)))) / 3 / size if size else 0.0
    if error > KINKED_GRADIENT:
        raise ToolkitError(
            f"the gradient of {problem.asked[place]} leaps beside this design: differences of it by two steps differ by {error:.1%} of "
            "themselves. A maximum that moves from place to place has kinks, its smooth maximum (ks-stress) has not."
        )
    return DerivedValue(value, second / scales, error)


def _difference(run: CaseRun, design: np.ndarray, step: float, along: np.ndarray, place: int) -> np.ndarray:
    """Derivative of a gradient (n,) along a direction, by designs on both sides."""
    ends = []
    for side in (1.0, -1.0):
        try:
            ends.append(run.at(design + side * step * along).gradients[place])
        except ToolkitError as error:
            raise ToolkitError(f"beside the design, for the gradient's norm: {error}") from error
    found: np.ndarray = (ends[0] - ends[1]) / (2 * step)
    return found


NOWHERE = JobState(EMPTY, EMPTY)


@one_thread()
def solve_design(
    problem: Problem,
    lane: int,
    design: np.ndarray,
    start: DesignOutcome | None,
    gradients: bool = True,
    curvatures: bool = False,
) -> DesignOutcome:
    """A design solved in all cases, or why it could not be.

    Parameters
    ----------
    problem
        The checked study.
    lane
        Under which it is kept.
    design
        Values of the variables, (n,).
    start
        A design whose equilibria statics begins in; None begins in the unloaded state.
    gradients
        Whether they are wanted; without them they are nan.
    curvatures
        Whether the second derivatives are wanted that the objective can tell.
    """
    begun, values, slopes, states, curved = time.perf_counter(), [], [], [], []
    for place, case in enumerate(problem.cases):
        where = f"{case}: " if case else ""
        try:
            known = start.states[place] if start else None
            value, slope, last, bent = _case(CaseRun(problem, case, known, gradients, curvatures), design)
        except ToolkitError as error:
            return _failure(lane, design, f"{where}{error}", begun)
        lost = [
            name
            for name, v, g in zip(problem.responses, value, slope, strict=True)
            if not np.all(np.isfinite([v, *(g if gradients else ())]))
        ]
        if lost:
            return _failure(lane, design, f"{where}{lost[0]} or its gradient does not exist at this design.", begun)
        values.append(value)
        slopes.append(slope)
        states.append(JobState(last.q[-1], last.multipliers[-1]) if problem.kind == "static" else NOWHERE)
        curved.append(bent)
    return DesignOutcome(
        lane=lane,
        design=design.copy(),
        values=np.array(values),
        gradients=np.array(slopes),
        states=tuple(states),
        curvatures=np.array(curved) if curvatures and problem.curved else EMPTY,
        seconds=time.perf_counter() - begun,
    )


def _failure(lane: int, design: np.ndarray, reason: str, begun: float) -> DesignOutcome:
    return DesignOutcome(lane=lane, design=design.copy(), reason=reason, seconds=time.perf_counter() - begun)


def _case(run: CaseRun, design: np.ndarray) -> CaseResult:
    problem = run.problem
    here = with_gradients(run).at(design)
    value, rows = list(here.values), list(here.gradients)
    for each in norms(with_gradients(run), design, here):
        value, rows = [*value, each.value], [*rows, each.slope]
    robust = list(statistics(run, design, here))
    value, rows = [*value, *(each.value for each in robust)], [*rows, *(each.slope for each in robust)]
    if problem.margin_up_to is not None:
        margin, slope = load_margin(here.solution, problem.margin_up_to)
        value, rows = [*value, margin], [*rows, slope]
    bent = [each.curvature for each in robust if each.curvature is not None] or list(here.curvatures)
    gradients = np.array(rows) if run.gradients else np.full((len(rows), len(design)), math.nan)
    return CaseResult(np.array(value), gradients, here.solution, np.array(bent))


def statistics(run: CaseRun, design: np.ndarray, here: CaseResult) -> Iterator[DerivedValue]:
    """Mean and standard deviation of what is to be robust, over the points of uncertain numbers; `here` is the run at the means."""
    problem = run.problem
    if problem.points is None:
        return
    ran = [here, *(_at_point(run, design, point) for point in range(1, len(problem.points)))]
    values, slopes = np.array([each.values for each in ran]), np.array([each.gradients for each in ran])
    squares, curved = list(problem.squares), np.array([each.curvatures for each in ran])
    for name, each in problem.statistics.items():
        weights = np.array([each.weights.get(asked, 0.0) for asked in problem.asked])
        undecided = _undecided(problem, weights, values)
        mean, by_mean, sigma, by_sigma = problem.points.statistics(values @ weights, weights @ slopes, undecided)
        bent = None
        if run.curvatures and name in problem.curved:
            shares = np.array([each.weights[square] for square in squares])
            parts = np.einsum("s,psxy->pxy", shares, curved)
            both = problem.points.curvatures(values @ weights, weights @ slopes, parts, undecided)
            bent = each.mean * both[0] + each.sigma * both[1]
        yield DerivedValue(each.mean * mean + each.sigma * sigma, each.mean * by_mean + each.sigma * by_sigma, curvature=bent)


def _undecided(problem: Problem, weights: np.ndarray, values: np.ndarray) -> float:
    shares = zip(problem.asked, weights, values.T, strict=True)
    return sum(abs(weight) * problem.undecided(name, column) for name, weight, column in shares)


def _at_point(run: CaseRun, design: np.ndarray, point: int) -> CaseResult:
    """The run at a point; whoever fails says which."""
    problem, points = run.problem, run.problem.points
    assert points is not None
    try:
        return run.at(design, point)
    except ToolkitError as error:
        moved = np.flatnonzero(points.shifts[point])
        there = points.at(point) | {problem.variables[k]: float((design + points.shifts[point])[k]) for k in moved}
        raise ToolkitError(f"where {', '.join(f'{name} = {value:.5g}' for name, value in there.items())}: {error}") from error


def load_margin(solution: Solution, up_to: float) -> tuple[float, np.ndarray]:
    """Load factor of the first limit point, at most `up_to`, and its gradient: zero where nothing snaps through so far.

    Raises
    ------
    NoLimitPointError
        The path could not be followed as far as that.
    BifurcationError
        The path becomes unstable before at a bifurcation, whose load factor has no gradient here.
    """
    nothing = np.zeros(solution.system.n_x)
    try:
        partials = LoadMargin(up_to=up_to).partials(solution)
    except NoLimitPointError as error:
        if error.reached < up_to:
            raise
        return up_to, nothing
    assert partials.design is not None
    return (float(np.real(partials.value)), partials.design) if np.real(partials.value) < up_to else (up_to, nothing)


def scene_at(problem: Problem, case: str, design: np.ndarray) -> Scene:
    """The scene of a case at a design, and at the means of uncertain numbers; load margins, which need not exist, are found beside it."""
    responses = {name: each for name, each in problem.scene.responses.items() if not isinstance(each, LoadMargin)}
    scene = problem.scene.model_copy(update={"responses": responses})
    means = problem.points.at(0) if problem.points else {}
    numbers = {**problem.cases[case], **means, **problem.numbers(design)}
    if problem.modes:
        followed = frequencies(problem, case, solve_statics(problem.compiled.at(numbers).primal))
        scene = scene.model_copy(update={"responses": {**responses, **followed}})
    return with_numbers(scene, numbers)[0]
