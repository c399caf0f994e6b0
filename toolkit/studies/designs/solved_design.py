"""One design solved in all cases: values and gradients, or the reason why there are none."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

import numpy as np

from toolkit.analyses.statics import solve_statics
from toolkit.foundation.errors import NoLimitPointError, ToolkitError
from toolkit.foundation.processes.one_thread import one_thread
from toolkit.responses.load_margin import LoadMargin
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.scene import Scene
from toolkit.studies.designs.case_run import CaseResult, CaseRun, frequencies
from toolkit.studies.designs.gradient_norms import DerivedValue, norms, with_gradients
from toolkit.studies.engine.outcome import EMPTY, DesignOutcome, State
from toolkit.studies.study.problem import Problem
from toolkit.system.solution import Solution

NOWHERE = State(EMPTY, EMPTY)


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
        states.append(State(last.q[-1], last.multipliers[-1]) if problem.kind == "static" else NOWHERE)
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
