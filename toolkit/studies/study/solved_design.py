"""One design solved in all cases: values and gradients, or the reason why there are none."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping

import numpy as np

from toolkit.analyses.statics import solve_statics
from toolkit.foundation.errors import NoLimitPointError, ToolkitError
from toolkit.foundation.processes.one_thread import one_thread
from toolkit.responses.load_margin import LoadMargin
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.scene import Scene
from toolkit.sensitivity.direct import evaluated, values_alone
from toolkit.sensitivity.methods import by_method
from toolkit.studies.study.evaluation import Evaluation, State
from toolkit.studies.study.problem import Problem
from toolkit.system.solution import Solution
from toolkit.system.system import System

NOWHERE = State(np.zeros(0), np.zeros(0))


@one_thread()
def solved(problem: Problem, lane: int, design: np.ndarray, start: Evaluation | None, gradients: bool = True) -> Evaluation:
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
    """
    begun, values, slopes, states = time.perf_counter(), [], [], []
    for place, (case, numbers) in enumerate(problem.cases.items()):
        where = f"{case}: " if case else ""
        try:
            value, slope, last = _case(problem, numbers, design, start.states[place] if start else None, gradients)
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
    return Evaluation(lane, design.copy(), "", np.array(values), np.array(slopes), tuple(states), time.perf_counter() - begun)


def _failure(lane: int, design: np.ndarray, reason: str, begun: float) -> Evaluation:
    return Evaluation(lane, design.copy(), reason, np.zeros(0), np.zeros(0), (), time.perf_counter() - begun)


def _case(
    problem: Problem, numbers: Mapping[str, float], design: np.ndarray, start: State | None, gradients: bool
) -> tuple[list[float], list[list[float]], Solution]:
    """Values and gradients of one case with the load margin, if that is asked for, as the last; and its solution."""
    compiled = problem.compiled.at({**numbers, **problem.numbers(design)})
    none = [math.nan] * len(problem.variables)
    if problem.kind == "transient":
        method = problem.study.search.gradients
        result = by_method(method, compiled, "transient", None, False) if gradients else values_alone(compiled, "transient")
    else:
        known = None if start is None else resting(compiled.primal.scene.solver.end_time, compiled.full, start)
        result = evaluated(solve_statics(compiled.full if gradients else compiled.primal, start=known), gradients)
    value = [result.values[name] for name in problem.asked]
    rows = [[result.gradients[name][x] for x in problem.variables] if gradients else none for name in problem.asked]
    if problem.margin_up_to is not None:
        margin, slope = load_margin(result.solution, problem.margin_up_to)
        value, rows = [*value, margin], [*rows, list(slope) if gradients else none]
    return value, rows, result.solution


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


def resting(time_of: float, system: System, state: State) -> Solution:
    """A kept equilibrium, as statics takes it for a start."""
    q, lam = state.q[None], state.multipliers[None]
    empty = np.zeros((1, len(state.q), 0))
    none = np.zeros_like(q)
    return Solution(
        system, np.array([time_of]), q, none, none, lam, empty, empty, empty, np.zeros((1, len(state.multipliers), 0))
    )


def scene_at(problem: Problem, case: str, design: np.ndarray) -> Scene:
    """The scene of a case at a design; load margins, which need not exist, are found beside it."""
    responses = {name: each for name, each in problem.scene.responses.items() if not isinstance(each, LoadMargin)}
    scene = problem.scene.model_copy(update={"responses": responses})
    return with_numbers(scene, {**problem.cases[case], **problem.numbers(design)})[0]
