"""One cell of a map: a scene run once with its gradient, and the numbers that tell whether either can be trusted."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import count
from typing import Any, Literal

import numpy as np

from toolkit.analyses.transient import simulate
from toolkit.foundation.errors import ConvergenceError, InputError, ModelFileError, NeedsDirectError, ToolkitError
from toolkit.responses.response import Response
from toolkit.scene.scene import Scene
from toolkit.sensitivity.adjoint.adjoint import adjoint_gradients
from toolkit.sensitivity.evaluation import by_name, evaluate_with_gradients
from toolkit.sensitivity.numerical import typical_size
from toolkit.sensitivity.preparation import prepare
from toolkit.system.solution import Solution
from toolkit.system.system import System
from toolkit.validity.motion.created_energy import created_energy

Status = Literal["ended", "failed", "refused"]
Slopes = dict[str, dict[str, float]]
MOST_REPORTS = 2000
"""Of progress, by one run; one that chooses its steps reports after 50 of them, or where their length changes, others after 200."""
NO_LIMIT = 1e300
"""Of the drift during a run: a map states how far joints opened, where an ordinary run only refuses."""

ROUND_OFF = 1e-12
"""Of slopes times the size of their variable, in parts of the response or of what it is measured by."""
MOST_MEMORY = 0.5
"""GB for the states of one run: several cells are measured at once, and one that chooses its steps may choose millions."""


@dataclass(frozen=True)
class Run:
    """How a run, or the differentiation of one, ended; the error's text if it did not."""

    status: Status = "ended"
    message: str = ""


@dataclass(frozen=True)
class Measured:
    """What one cell gave.

    `drift` is the largest opening of a joint, relative to the scene's size or in rad; `created` is `created_energy`. `slopes` are
    derivatives times the size of their variable, so that all slopes of a response are comparable; `disagreement` is the largest
    difference of direct differentiation and adjoint, over the largest slope of each response. `undecided` is up to where slopes of a
    response may be round-off.
    """

    run: Run
    gradient: Run | None = None  # None: no variables
    drift: float = 0.0
    created: float = 0.0
    values: dict[str, float] = field(default_factory=dict)
    slopes: Slopes = field(default_factory=dict)
    disagreement: float = 0.0
    steps: int = 0
    newton_iterations: int = 0
    seconds: float = 0.0
    undecided: dict[str, float] = field(default_factory=dict)


def measure(scene: Scene, design: list[str], sizes: Mapping[str, float] | None = None, both_methods: bool = True) -> Measured:
    """Run a scene with all derivatives; whatever it raises becomes part of the result.

    Parameters
    ----------
    scene : Scene
    design : design variables; without any there is no gradient to judge
    sizes : variable -> what its derivatives are multiplied by; by default its value
    both_methods : whether the adjoint judges direct differentiation; a run that others are compared with needs no judge
    """
    begun = clock.perf_counter()
    with np.errstate(all="ignore"):  # a run that blows up does so in numpy too
        found = _measured(scene, design, sizes, both_methods)
    return replace(found, seconds=clock.perf_counter() - begun)


def _measured(scene: Scene, design: list[str], sizes: Mapping[str, float] | None, both_methods: bool) -> Measured:
    try:
        system = prepare(scene, design)
        solution = simulate(system, _without_limit(scene), progress=None if scene.solver.local_error is None else _patience())
        responses, gradients = evaluate_with_gradients(solution)
    except (ToolkitError, np.linalg.LinAlgError) as error:
        return _without_gradient(scene, error) if design else Measured(_outcome(error))
    values = {name: float(np.real(value)) for name, value in responses.items()}
    cost: dict[str, Any] = {"steps": solution.steps, "newton_iterations": solution.newton_iterations}
    found = Measured(Run(), None, float(solution.drift), created_energy(solution), values, **cost)
    if not design:
        return found
    sizes = sizes or {variable.name: typical_size(scene, variable) for variable in system.design}
    slopes = _times(gradients, sizes)
    least = _undecided(scene, values)
    outcome, disagreement = _judged(system, solution, slopes, sizes, least) if both_methods else (Run(), np.nan)
    return replace(found, gradient=outcome, slopes=slopes, disagreement=disagreement, undecided=least)


def _undecided(scene: Scene, values: Mapping[str, float]) -> dict[str, float]:
    """Up to where slopes are round-off: a part of the response, and of the scene's size or a rad, where it is a place or an angle."""
    sizes, known = {"angle": 1.0, "length": scene.size}, scene.responses
    own = {name: sizes.get(each.unit_quantity, 0.0) for name, each in known.items() if isinstance(each, Response)}
    return {name: ROUND_OFF * max(abs(value), own.get(name, 0.0)) for name, value in values.items()}


def _without_gradient(scene: Scene, error: Exception) -> Measured:
    """The run alone: perhaps only its derivatives failed."""
    alone = _measured(scene, [], None, False)
    return replace(alone, gradient=_outcome(error) if alone.run.status == "ended" else alone.run)


def _without_limit(scene: Scene):
    memory = min(scene.solver.memory, MOST_MEMORY)
    return scene.solver.model_copy(
        update={"drift_tolerance": NO_LIMIT, "memory": memory, "halvings": 0}
    )  # steps are as long as told


def _patience() -> Callable[[int, int], None]:
    """Ends a run that reports its progress too often: one that chooses its steps, and they become ever shorter."""
    reports = count()

    def told(_done: int, _all: int) -> None:
        if next(reports) > MOST_REPORTS:
            raise ConvergenceError(
                "the steps that error control chooses are so short that the run does not end in a reasonable time. Allow a larger "
                "solver.local_error."
            )

    return told


def _outcome(error: Exception) -> Run:
    refused = isinstance(error, (InputError, ModelFileError))
    return Run("refused" if refused else "failed", str(error))


def _judged(
    system: System, solution: Solution, slopes: Slopes, sizes: Mapping[str, float], undecided: Mapping[str, float]
) -> tuple[Run, float]:
    """How the adjoint ended, and how far its slopes are from those of direct differentiation; nan where it has none."""
    try:
        responses, found = adjoint_gradients(system, solution)
    except NeedsDirectError:
        return Run(), np.nan  # one method is left, and nothing to compare it with
    except ToolkitError as error:
        return Run("failed", f"adjoint: {error}"), np.nan
    return Run(), slope_difference(_times(by_name(system.design, responses, found.T), sizes), slopes, undecided)


def _times(gradients: Slopes, sizes: Mapping[str, float]) -> Slopes:
    return {f: {x: slope * sizes[x] for x, slope in row.items()} for f, row in gradients.items()}


def slope_difference(one: Slopes, other: Slopes, undecided: Mapping[str, float]) -> float:
    """Largest difference of slopes, over the largest slope in `other` of the same response.

    Derivatives that do not exist in `other` are left out; one that is lost, or a response that gained one, counts as infinite. Slopes that
    are zero but for round-off, up to `undecided`, differ by nothing.
    """
    largest = 0.0
    for f, row in other.items():
        theirs, ours = np.array(list(row.values())), np.array([one[f][x] for x in row])
        exists = ~np.isnan(theirs)
        if exists.any():
            off, size = np.abs(ours[exists] - theirs[exists]).max(), np.abs(theirs[exists]).max()
            nothing = max(off, size) <= undecided.get(f, 0.0)
            largest = largest if nothing else max(largest, _ratio(off, size))
    return largest


def value_difference(one: Measured, other: Measured) -> float:
    """Largest difference of responses, each over what it is in `other` or over what a variable's own size changes there."""
    largest = 0.0
    for f, value in other.values.items():
        scale = max([abs(value), *(abs(s) for s in other.slopes.get(f, {}).values() if np.isfinite(s))])
        largest = max(largest, _ratio(abs(one.values[f] - value), scale))
    return largest


def _ratio(difference: float, scale: float) -> float:
    """Relative difference; nan and the change of a zero are infinite."""
    if difference == 0:
        return 0.0
    found = difference / scale if scale > 0 else np.inf
    return float(found) if np.isfinite(found) else np.inf
