"""One design solved in all cases: values and gradients, or the reason why there are none."""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np

from toolkit.analyses.statics import solve_statics
from toolkit.foundation.errors import NoLimitPointError, ToolkitError
from toolkit.foundation.processes.one_thread import one_thread
from toolkit.responses.load_margin import LoadMargin
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.scene import Scene
from toolkit.studies.evaluation.case_run import CaseRun, frequencies
from toolkit.studies.evaluation.evaluation import Evaluation, State
from toolkit.studies.evaluation.gradient_norms import norms, with_gradients
from toolkit.studies.evaluation.statistics import statistics
from toolkit.studies.study.problem import Problem
from toolkit.system.solution import Solution

NOWHERE = State(np.zeros(0), np.zeros(0))


@one_thread()
def solved(
    problem: Problem,
    lane: int,
    design: np.ndarray,
    start: Evaluation | None,
    gradients: bool = True,
    curvatures: bool = False,
) -> Evaluation:
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
            value, slope, bent, last = _case(CaseRun(problem, case, known, gradients, curvatures), design)
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
    rows, wall = (np.array(values), np.array(slopes), tuple(states)), time.perf_counter() - begun
    return Evaluation(lane, design.copy(), "", *rows, wall, np.array(curved) if curvatures and problem.curved else np.zeros(0))


def _failure(lane: int, design: np.ndarray, reason: str, begun: float) -> Evaluation:
    return Evaluation(lane, design.copy(), reason, np.zeros(0), np.zeros(0), (), time.perf_counter() - begun)


class _Case(NamedTuple):
    """Values and gradients of one case, in the order of the problem's responses; curvatures in that of `Problem.curved`; and the run."""

    values: list[float]
    slopes: list[np.ndarray]
    curvatures: list[np.ndarray]
    solution: Solution


def _case(run: CaseRun, design: np.ndarray) -> _Case:
    problem, none = run.problem, np.full(len(design), math.nan)
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
    return _Case(value, rows if run.gradients else [none] * len(rows), bent, here.solution)


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
