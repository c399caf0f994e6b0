"""The best design of a study: searched for from several starts, solved again, and judged."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.studies.design_work import Evaluator, cut_off
from toolkit.studies.optimization.explored import SearchResult
from toolkit.studies.optimization.optimum import NoOptimumError, Optimum, RobustnessCheck, compared
from toolkit.studies.optimization.program import Price, Program, dependent, objective_of, prices
from toolkit.studies.optimization.search import SearchRun, starts_of
from toolkit.studies.optimization.verification import Verification, certified, said_of_norms, said_of_runs, solved_again
from toolkit.studies.problem import ONLY, Problem
from toolkit.studies.store import DesignOutcome, DesignStore, opened_store
from toolkit.studies.study_file import LOAD_MARGIN

Progress = Callable[[int, int], None]
STORE = "study.h5"
"""Name of the store in the folder of a study."""
DESIGNS_AROUND_START = 4
"""Number of further designs at which the objective is evaluated where it is stationary at the start."""
SAME_OBJECTIVE = 1e-3
"""Relative difference of objectives by which two optima are distinguished."""

SAME_DESIGN = 0.05
"""Difference of a variable, relative to its scale, by which two designs are distinguished."""


def optimized(problem: Problem, folder: Path | None = None, progress: Progress | None = None) -> Optimum:
    """Search for the best design of a problem.

    Parameters
    ----------
    problem
        The checked study.
    folder
        Where all designs are kept, and found again after an interruption; None keeps nothing.
    progress
        Called with the designs solved and the most that may be.

    Raises
    ------
    InputError
        No variable moves the objective; or the folder holds another study, or another run works in it.
    NoOptimumError
        Not one design could be solved.
    """
    begun = time.perf_counter()
    options = problem.study.search
    count, asked = options.starts * options.evaluations, 0

    def tell(_: DesignOutcome) -> None:
        nonlocal asked
        asked += 1
        if progress:
            progress(min(asked, count), count)

    with opened_store(None if folder is None else folder / STORE, problem.fingerprint) as store:
        evaluator = Evaluator(problem, store)
        known_wall = sum(each.seconds for each in store)
        starts = starts_of(problem, options.starts)
        _refuse_idle_objective(problem, evaluator, starts[0])
        searches: list[SearchResult] = []
        for k, start in enumerate(starts):
            known = next((each.best.design for each in searches if each.best is not None), None)
            searches.append(SearchRun(Program(problem), evaluator, 2 * k, options.warm_starts, tell).run(start, known))
        _refuse_all_failed(problem, store, searches)
        order = sorted((k for k, each in enumerate(searches) if each.best is not None), key=lambda k: _rank(searches[k]))
        chosen, again = searches[order[0]], None
        for k in order:
            found, again = _verified(problem, evaluator, searches[k], tell)
            searches[k] = chosen = found
            if not again.refusal:
                break
        assert again is not None
    first = next(iter(store.of(0)), None)
    cautions = [*_cautions(problem, chosen, again, searches), *_idle(problem, store), *_cases(problem)]
    if chosen.best is not None:
        cautions += said_of_runs(problem, chosen.best, again)
    if options.certify and not again.refusal and chosen.best is not None:
        cautions += certified(problem, chosen.best, again)
    robust: list[RobustnessCheck] = []
    if chosen.best is not None and not again.refusal:
        robust, doubts = compared(problem, chosen.best)
        cautions += [*doubts, *said_of_norms(problem, chosen.best)]
    costs = _prices(chosen)
    wall = time.perf_counter() - begun + known_wall
    good = first if first is not None and not first.failed else None
    return Optimum(problem, chosen, tuple(searches), again, costs, Verdict.of(cautions), good, tuple(store), wall, tuple(robust))


def _rank(found: SearchResult) -> tuple[bool, bool, float]:
    """Key by which designs of searches are tried: optima by their objective, then feasible ones, then the least violated."""
    assert found.best is not None
    assert found.optimality is not None
    problem = found.program.problem
    feasible = found.optimality.violation <= problem.study.search.feasibility
    value = problem.study.objective.sign * float(found.program.objective(found.best.values)[0])
    return (not found.arrived, not feasible, value if feasible else found.optimality.violation)


def _verified(
    problem: Problem, evaluator: Evaluator, found: SearchResult, tell: Callable[[DesignOutcome], None]
) -> tuple[SearchResult, Verification]:
    """A search's design solved again; where that fails after warm starts, the search is repeated without them."""
    assert found.best is not None
    again = solved_again(problem, found.best)
    if again.refusal and problem.kind == "static" and found.lane % 2 == 0 and problem.study.search.warm_starts:
        repeated = SearchRun(Program(problem), evaluator, found.lane + 1, False, tell).run(found.start, problem.start)
        if repeated.best is not None:
            return repeated, solved_again(problem, repeated.best)
    return found, again


def _refuse_idle_objective(problem: Problem, evaluator: Evaluator, start: np.ndarray) -> None:
    """Refuse an objective that no variable moves, at the start or at other designs."""
    program, designs = Program(problem), set()
    for k, look in enumerate([start, *starts_of(problem, DESIGNS_AROUND_START + 1)[1:]]):
        lane, warm = (-1, False) if k else (0, problem.study.search.warm_starts)
        found = evaluator(lane, program.design(program.scaled(look)), warm)
        if found.failed:
            continue
        designs.add(found.design.tobytes())
        if np.any(np.abs(program.values(found).df) > _undecided(problem, found)):
            return
    if len(designs) < 2:
        return  # the start is stationary or cannot be solved, and nothing else could be
    raise InputError(
        f"objective: no variable moves {objective_of(Program(problem))[0]}: its derivatives are zero, by "
        f"{', '.join(problem.variables)}. Choose other variables, or another response."
    )


def _undecided(problem: Problem, found: DesignOutcome) -> float:
    """Part of the objective that round-off may decide."""
    weights = problem.weights
    left = ((name, problem.undecided(name, found.values[:, k])) for k, name in enumerate(problem.responses))
    return sum(abs(weights.get(name, 0.0)) * each for name, each in left)


def _refuse_all_failed(problem: Problem, store: DesignStore, searches: list[SearchResult]) -> None:
    if any(each.best is not None for each in searches):
        return
    reasons = []
    for found in searches:
        first = next((each.reason for each in store.of(found.lane)), found.ended)
        reasons.append(f"start {found.lane // 2 + 1}: {first}")
    raise NoOptimumError(
        "not one design could be solved, so that there is nothing to begin from.\n"
        + "\n".join(dict.fromkeys(reasons))
        + "\nMend the scene until `ffrf statics` or `ffrf simulate` solves it, or ask for more starts."
    )


def _prices(found: SearchResult) -> tuple[Price, ...]:
    assert found.best is not None
    assert found.optimality is not None
    return tuple(prices(found.program, found.best, found.optimality))


def _cautions(problem: Problem, found: SearchResult, again: Verification, searches: list[SearchResult]) -> Iterator[Caution]:
    """Cautions that speak against the design being the optimum."""
    assert found.best is not None
    assert found.optimality is not None
    left, options = found.optimality, problem.study.search
    values = found.program.values(found.best)
    if again.refusal:
        yield Caution("not-found-again", f"solved again along the path from the unloaded state: {again.refusal}")
    if left.violation > options.feasibility:
        row = found.program.rows[int(np.argmin(values.c))]
        yield Caution(
            "infeasible",
            f"no design keeps all constraints: the nearest has {row.label} off its limit {row.limit:g} by {left.violation * row.size:.3g} "
            f"{problem.unit_of(row.response)}; {found.ended}. Widen bounds or limits, or give more starts.".replace("  ", " "),
        )
    if not left.met(options.optimality, options.feasibility):
        more = f", the curvature promises {left.gain:.1e} of the objective more" if left.gain > options.optimality else ""
        yield Caution(
            "not-optimal",
            f"the KKT residual is {left.residual:.1e} of the objective's scale{more}, and {options.optimality:.1e} is wanted: "
            f"{found.ended}. Give more evaluations, more starts, or another method.",
        )
    yield from _margins(problem, found.best)
    if dependent(found.program, found.best, left):
        yield Caution("prices", "active limits depend on each other: their prices can be shared in other ways too.", doubt=False)
    yield from _other_optima(problem, found, searches)
    yield from _unfinished(found, searches)
    yield from _flat(problem, found, searches)
    failed, count = sum(each.failed for each in searches), sum(each.evaluations for each in searches)
    if failed:
        yield Caution("failed-designs", f"{failed} of {count} designs could not be solved; none counts.", doubt=False)


def _margins(problem: Problem, best: DesignOutcome) -> Iterator[Caution]:
    """A caution about load margins at the design of which only the least value is known.

    They have no slope, so that the design may look like an optimum.
    """
    cut = [case for k, case in enumerate(problem.cases) if cut_off(problem, best, (k, len(problem.responses) - 1))]
    if cut:
        where = f" ({', '.join(cut)})" if cut != [ONLY] else ""
        asked = LOAD_MARGIN in problem.weights
        then = (
            "so that the objective has no slope there, and other designs may be better"
            if asked
            else "and limits on it are not active"
        )
        found = f"no limit point up to {problem.margin_up_to:g} times the load{where}: {LOAD_MARGIN} is at least that"
        text = f"{found}, cut off there, {then}."
        yield Caution("margin-cut-off", text, doubt=asked)


def _idle(problem: Problem, store: DesignStore) -> Iterator[Caution]:
    """A remark on variables that have moved nothing at any design."""
    slopes = [each.gradients for each in store if not each.failed]
    idle = [name for k, name in enumerate(problem.variables) if not any(np.any(each[:, :, k]) for each in slopes)]
    if idle:
        yield Caution("idle", f"nothing that the study asks for depends on {', '.join(idle)}.", doubt=False)


def _cases(problem: Problem) -> Iterator[Caution]:
    """A remark that the scene as it stands does not count, where all cases have other numbers."""
    if problem.study.cases and all(problem.study.cases.values()):
        listed = ", ".join(problem.study.cases)
        yield Caution(
            "cases",
            f"the design is that for {listed} alone: the scene as it stands is none of the cases. If it is to count too, write a table "
            "without numbers, such as [cases.normal].",
            doubt=False,
        )


def _flat(problem: Problem, found: SearchResult, searches: list[SearchResult]) -> Iterator[Caution]:
    """A remark that searches ended at the same objective with other designs: the optimum is not a single point."""
    ended = [each for each in searches if each.arrived and each.best is not None]
    values = np.array([float(each.program.objective(each.best.values)[0]) for each in ended if each.best is not None])
    designs = np.array([each.best.design for each in ended if each.best is not None])
    if not found.arrived or found.best is None or len(ended) < 2:
        return
    mine = float(found.program.objective(found.best.values)[0])
    same = designs[np.abs(values - mine) <= SAME_OBJECTIVE * abs(mine)]
    low, high = np.min(same, axis=0, initial=np.inf), np.max(same, axis=0, initial=-np.inf)
    wide = [
        f"{problem.variables[k]} from {low[k]:.5g} to {high[k]:.5g}"
        for k in np.flatnonzero(high - low > SAME_DESIGN * problem.scales)
    ]
    if wide:
        yield Caution(
            "flat-optimum",
            f"{len(same)} of {len(searches)} searches ended at the same objective within {100 * SAME_OBJECTIVE:g} %, with "
            f"{', '.join(wide)}: it "
            "decides nothing between these designs; add what does to the objective, or tighten search.optimality.",
            doubt=False,
        )


def _unfinished(found: SearchResult, searches: list[SearchResult]) -> Iterator[Caution]:
    """A remark that other searches ended before an optimum, so that fewer were compared than were asked for."""
    left = [each for each in searches if not each.arrived]
    if found.arrived and left:
        why = ", ".join(f"start {each.lane // 2 + 1}: {each.ended}" for each in left[:3]) + (", ..." if len(left) > 3 else "")
        yield Caution(
            "unfinished-searches",
            f"{len(left)} of {len(searches)} searches ended at no optimum ({why}), so that there may be a better one. Give more "
            "evaluations, or narrower bounds.",
            doubt=False,
        )


def _other_optima(problem: Problem, found: SearchResult, searches: list[SearchResult]) -> Iterator[Caution]:
    """Remarks that other searches ended in other optima, or at a better design that is no optimum yet."""
    assert found.best is not None
    mine = float(found.program.objective(found.best.values)[0])
    (_, mine_off, value), ranked = _rank(found), [_rank(each) for each in searches if each is not found and each.best is not None]
    better = [each for each in ranked if not each[1] and not mine_off and each[2] < value - SAME_OBJECTIVE * abs(value)]
    if found.arrived and better:
        yield Caution(
            "better-designs",
            f"{len(better)} of {len(searches)} searches stood at a better design when they ended, which is no optimum yet, or was not "
            "found again: give more evaluations.",
            doubt=False,
        )
    others = [each for each in searches if each.arrived and each is not found and each.best is not None]
    values = [float(each.program.objective(each.best.values)[0]) for each in others if each.best is not None]
    elsewhere = [value for value in values if abs(value - mine) > SAME_OBJECTIVE * max(abs(value), abs(mine))]
    if elsewhere:
        yield Caution(
            "local-optima",
            f"{len(elsewhere)} of {len(searches)} searches ended in other optima, with objectives from {min(elsewhere):.6g} to "
            f"{max(elsewhere):.6g}; there may be better ones still.",
            doubt=False,
        )
