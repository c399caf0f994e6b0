"""Designs solved in all cases, each once: what a store holds already is not solved again."""

from __future__ import annotations

import time
from collections.abc import Mapping

import numpy as np

from toolkit.analyses.statics import solve_statics
from toolkit.foundation.errors import NoLimitPointError, ToolkitError
from toolkit.responses.load_margin import LoadMargin
from toolkit.sensitivity.direct import evaluated
from toolkit.sensitivity.methods import by_method
from toolkit.sensitivity.result import Result
from toolkit.studies.study.evaluation import Evaluation, State
from toolkit.studies.study.problem import Problem
from toolkit.studies.study.store import Store
from toolkit.system.solution import Solution
from toolkit.system.system import System

NOWHERE = State(np.zeros(0), np.zeros(0))


class Evaluator:
    """Solves designs of a problem, and keeps them.

    Every number follows from the design and from what the same search has solved before it, so that a search which was killed and goes on
    from its store gives the same bits.
    """

    def __init__(self, problem: Problem, store: Store) -> None:
        self.problem = problem
        self.store = store

    def __call__(self, lane: int, design: np.ndarray, warm: bool) -> Evaluation:
        """The design, from the store or solved now; `warm` begins statics in the nearest design of the same lane."""
        known = self.store.find(lane, design)
        if known is not None:
            return known
        begun = time.perf_counter()
        start = self._nearest(lane, design) if warm and self.problem.kind == "static" else None
        found = self._solved(lane, design, start, begun)
        self.store.keep(found)
        return found

    def _nearest(self, lane: int, design: np.ndarray) -> Evaluation | None:
        """The nearest design of the lane that could be solved, the earlier of two."""
        known = [each for each in self.store.of(lane) if not each.failed]
        distances = [float(np.sum(((each.design - design) / self.problem.scales) ** 2)) for each in known]
        return known[int(np.argmin(distances))] if known else None

    def _solved(self, lane: int, design: np.ndarray, start: Evaluation | None, begun: float) -> Evaluation:
        values, gradients, states = [], [], []
        for place, (case, numbers) in enumerate(self.problem.cases.items()):
            where = f"{case}: " if case else ""
            try:
                result, margin, slope = self._case(numbers, design, start.states[place] if start else None)
            except ToolkitError as error:
                return self._failure(lane, design, f"{where}{error}", begun)
            value = [result.values[name] for name in self.problem.asked]
            rows = [[result.gradients[name][x] for x in self.problem.variables] for name in self.problem.asked]
            if margin is not None:
                value, rows = [*value, margin], [*rows, list(slope)]
            lost = [
                name for name, v, g in zip(self.problem.responses, value, rows, strict=True) if not np.all(np.isfinite([v, *g]))
            ]
            if lost:
                return self._failure(lane, design, f"{where}{lost[0]} or its gradient does not exist at this design.", begun)
            values.append(value)
            gradients.append(rows)
            last = result.solution
            states.append(State(last.q[-1], last.multipliers[-1]) if self.problem.kind == "static" else NOWHERE)
        return Evaluation(
            lane, design.copy(), "", np.array(values), np.array(gradients), tuple(states), time.perf_counter() - begun
        )

    def _failure(self, lane: int, design: np.ndarray, reason: str, begun: float) -> Evaluation:
        return Evaluation(lane, design.copy(), reason, np.zeros(0), np.zeros(0), (), time.perf_counter() - begun)

    def _case(
        self, numbers: Mapping[str, float], design: np.ndarray, start: State | None
    ) -> tuple[Result, float | None, np.ndarray]:
        """The run of one case, its load margin if that is asked for, and the margin's gradient."""
        problem = self.problem
        compiled = problem.compiled.at({**numbers, **problem.numbers(design)})
        none = np.zeros(len(problem.variables))
        if problem.kind == "transient":
            return by_method(problem.study.search.gradients, compiled, "transient", None, False), None, none
        known = None if start is None else resting(compiled.primal.scene.solver.end_time, compiled.full, start)
        solution = solve_statics(compiled.full, start=known)
        result = evaluated(solution, True)
        if problem.margin_up_to is None:
            return result, None, none
        return result, *load_margin(solution, problem.margin_up_to)


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
