"""An optimum solved again: along the path from the unloaded state, with finer steps, and with its gradients certified."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

from toolkit.analyses.sensitivity.certificate.certificate import certify
from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.direct import direct, values_alone
from toolkit.analyses.sensitivity.run import Run
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import NoLimitPointError, ToolkitError
from toolkit.foundation.verdict import Caution
from toolkit.responses.least_frequency import LoadMargin
from toolkit.scene.scene import Scene
from toolkit.studies.problem import LARGEST_LOAD_FACTOR, Problem, by_case
from toolkit.studies.solved_design import CaseRun, load_margin, norms, scene_at, solve_design
from toolkit.studies.store import DesignOutcome
from toolkit.studies.study_file import LOAD_MARGIN
from toolkit.studies.wanted import norm_of
from toolkit.validity.bodies.physics import critical_loads

OTHER_EQUILIBRIUM = 1e-5
"""Relative change of a response by which an equilibrium is another one than that of the search: finer load steps and a warm start
change nothing but round-off."""
COARSE_STEPS_CHANGE = 1e-2
"""Relative change of a response of a motion by finer steps above which the steps were too long."""
EXACT_METHODS_DIFFERENCE = 1e-8
"""Relative difference of derivatives by exact methods that is an error, as in `ffrf certify`."""
IMPORTANT_DERIVATIVE = 1e-6
"""Part of a response that a derivative by a variable of its size must mean to be compared: at an optimum parts cancel, and what is left of
them has few digits."""


@dataclass(frozen=True)
class Verification:
    """Result of solving a design again.

    Attributes
    ----------
    results
        Case -> run with finer steps, with all responses of the scene; those before the one that failed.
    refusal
        Why the design is none after all; empty if nothing speaks against it.
    changes
        Response, with its case -> change by the finer steps in parts of its size.
    margins
        Case -> load factor of the first limit point, or of what was searched without finding any; whether one was found.
    """

    results: dict[str, Run]
    refusal: str
    changes: dict[str, float]
    margins: dict[str, tuple[float, bool]]
    cautions: tuple[Caution, ...] = ()


def solved_again(problem: Problem, found: DesignOutcome) -> Verification:
    """Solve a design of a search again in all cases, without anything that the search knew."""
    results: dict[str, Run] = {}
    margins: dict[str, tuple[float, bool]] = {}
    changes: dict[str, float] = {}
    cautions: list[Caution] = []
    derived = _derived(problem, found)
    if derived is not None and derived.failed:
        return Verification(results, derived.reason, changes, margins)
    for k, case in enumerate(problem.cases):
        where = f"{case}: " if case else ""
        try:
            results[case] = direct(finer(scene_at(problem, case, found.design)), list(problem.variables), problem.kind)
            if _has_margin(problem):
                margins[case] = _margin(problem, results[case], where, cautions)
        except ToolkitError as error:
            return Verification(results, f"{where}{error}", changes, margins)
        values = {**results[case].values, **({LOAD_MARGIN: margins[case][0]} if case in margins else {})}
        if derived is not None:
            names = (*map(norm_of, problem.norms), *problem.statistics)
            values |= {name: derived.values[k, problem.responses.index(name)] for name in names}
        for name, before in zip(problem.responses, found.values[k], strict=True):
            after = min(values[name], problem.margin_up_to or LARGEST_LOAD_FACTOR) if name == LOAD_MARGIN else values[name]
            size = max([abs(before), *(abs(each.bound) for each in problem.limits if each.response == name)])
            changes[by_case([case], name)[0]] = abs(after - before) / (size or 1.0)
    return Verification(results, _changed(problem, changes), changes, margins, tuple(cautions))


def _changed(problem: Problem, changes: dict[str, float]) -> str:
    worst = max(changes, key=lambda name: changes[name])
    if problem.kind == "static" and changes[worst] > OTHER_EQUILIBRIUM:
        return (
            f"the path from the unloaded state leads to another equilibrium: {worst} changes by {100 * changes[worst]:.3g} %. The design "
            "of the search lies beyond a snap-through."
        )
    if changes[worst] > COARSE_STEPS_CHANGE:
        return f"with steps half as long {worst} changes by {100 * changes[worst]:.3g} %. Give the scene a smaller solver.step."
    return ""


def _derived(problem: Problem, found: DesignOutcome) -> DesignOutcome | None:
    """The design solved with finer steps at all points of uncertain numbers and beside it; None if nothing asks for these.

    Load margins are left out; they are found apart.
    """
    if problem.points is None and not problem.norms:
        return None
    constraints = {name: each for name, each in problem.study.constraints.items() if name != LOAD_MARGIN}
    study = problem.study.model_copy(update={"constraints": constraints})
    return solve_design(
        replace(problem, study=study, scene=finer(problem.scene)), found.lane, found.design, None, gradients=False
    )


def _has_margin(problem: Problem) -> bool:
    solver = problem.scene.solver
    return problem.kind == "static" and solver.equilibrium == "rest" and solver.continuation == "load"


def _margin(problem: Problem, result: Run, where: str, cautions: list[Caution]) -> tuple[float, bool]:
    """Load factor of the first limit point, and whether there is one.

    A path that cannot be followed gives a remark, or an error if the load margin is asked for.
    """
    up_to = max(problem.margin_up_to or 0.0, LARGEST_LOAD_FACTOR)
    try:
        value = load_margin(result.solution, up_to)[0]
    except NoLimitPointError as error:
        return error.reached, False
    except ToolkitError as error:
        factor = getattr(error, "load_factor", None)
        if problem.margin_up_to is not None and (factor is None or factor < problem.margin_up_to):
            raise
        cautions.append(Caution("load-margin", f"{where}the path beyond the full load: {error}", doubt=False))
        return (float(factor), True) if factor is not None else (1.0, False)
    return value, value < up_to


def finer(scene: Scene) -> Scene:
    """The scene with steps half as long."""
    options: RunOptions = scene.solver
    times = None if options.times is None else [float(t) for t in options.times]
    halved: dict[str, Any] = {"step": options.step / 2, "load_steps": 2 * options.load_steps}
    if options.local_error is not None:
        halved["local_error"] = options.local_error / 4
    if times is not None:
        between = [(a + b) / 2 for a, b in pairwise(times)]
        halved["times"] = tuple(sorted([*times, *between]))
    return scene.model_copy(update={"solver": options.model_copy(update=halved)})


def certified(problem: Problem, found: DesignOutcome, again: Verification) -> Iterator[Caution]:
    """Doubts of independent methods about the gradients at a design; none if they agree."""
    for k, case in enumerate(problem.cases):
        where = f"{case}: " if case else ""
        scene = scene_at(problem, case, found.design)
        asked: dict[str, Any] = {name: scene.responses[name] for name in problem.asked}
        if LOAD_MARGIN in problem.responses and again.margins[case][1] and found.values[k][-1] < (problem.margin_up_to or 0.0):
            asked[LOAD_MARGIN] = LoadMargin(up_to=problem.margin_up_to or LARGEST_LOAD_FACTOR)
        try:
            certificate = certify(
                scene.model_copy(update={"responses": asked}), list(problem.variables), problem.kind, unseen=IMPORTANT_DERIVATIVE
            )
            certificate.check(EXACT_METHODS_DIFFERENCE)
        except ToolkitError as error:
            yield Caution("gradients", f"{where}the gradients at the optimum could not be certified: {error}")
            continue
        known = again.results[case].verdict.warnings if case in again.results else ()
        yield from (_in(where, each) for each in certificate.verdict.warnings if each not in known and each.code == "differences")


def said_of_norms(problem: Problem, found: DesignOutcome) -> Iterator[Caution]:
    """A remark on the error of the derivatives of norms of gradients, which alone are differences."""
    for case in problem.cases if problem.norms else ():
        where, run = f"{case}: " if case else "", CaseRun(problem, case, None, gradients=True)
        try:
            errors = [each.error for each in norms(run, found.design, run.at(found.design))]
        except ToolkitError as error:
            yield Caution("differences", f"{where}the norm of a gradient could not be found again: {error}")
            return
        told = ", ".join(f"that of {name} by {each:.1e}" for name, each in zip(problem.norms, errors, strict=True))
        text = f"{where}derivatives of norms of gradients are differences of exact gradients, off by at most, in parts: {told}."
        yield Caution("differences", text, doubt=False)


def _in(where: str, caution: Caution) -> Caution:
    return Caution(caution.code, f"{where}{caution.text}", caution.doubt)


def said_of_runs(problem: Problem, found: DesignOutcome, again: Verification) -> Iterator[Caution]:
    """Cautions of the runs at the optimum: those of an analysis of its scene, and further ones of the run with finer steps."""
    for case, finer_run in again.results.items():
        where = f"{case}: " if case else ""
        own = [*_said_as_it_stands(problem, case, found)]
        told = {each.code for each in own}
        yield from (_in(where, each) for each in own)
        yield from (_in(where, each) for each in finer_run.verdict.warnings if each.code not in told)


def _said_as_it_stands(problem: Problem, case: str, found: DesignOutcome) -> Iterator[Caution]:
    """Cautions of `statics` or `simulate` about the scene at a design.

    Load margins, which stand beside it here, feel what bends it, too.
    """
    try:
        run = values_alone(Compiled(scene_at(problem, case, found.design)), problem.kind)
    except ToolkitError as error:
        yield Caution("not-found-again", f"with the steps of the scene: {error}")
        return
    asked = LOAD_MARGIN in problem.responses or any(isinstance(each, LoadMargin) for each in problem.scene.responses.values())
    yield from (each for each in run.verdict.warnings if not (asked and each.code == "critical-load"))
    if asked:
        yield from critical_loads(run.solution, lateral=True)
