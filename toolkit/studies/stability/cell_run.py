"""The job of one cell of a map: a scene run once with its gradient, and the numbers that tell whether either can be trusted."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from toolkit.analyses.transient import simulate
from toolkit.foundation.errors import ConvergenceError, InputError, ModelFileError, NeedsDirectError, ToolkitError
from toolkit.responses.response import Response
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.sensitivity.adjoint.adjoint import adjoint_gradients
from toolkit.sensitivity.evaluation import by_name, evaluate_with_gradients
from toolkit.sensitivity.numerical import typical_size
from toolkit.sensitivity.preparation import prepare
from toolkit.studies.engine.fingerprint import scene_fingerprint
from toolkit.studies.stability.cell_outcome import CellOutcome, Ending, Slopes, slope_difference
from toolkit.system.solution import Solution
from toolkit.system.system import System
from toolkit.validity.motion.created_energy import created_energy

MOST_REPORTS = 2000
"""Of progress, by one run; one that chooses its steps reports after 50 of them, or where their length changes, others after 200."""
NO_LIMIT = 1e300
"""Of the drift during a run: a map states how far joints opened, where an ordinary run only refuses."""

ROUND_OFF = 1e-12
"""Of slopes times the size of their variable, in parts of the response or of what it is measured by."""
MOST_MEMORY = 0.5
"""GB for the states of one run: several cells are measured at once, and one that chooses its steps may choose millions."""


@dataclass(frozen=True)
class CellJob:
    """A cell that is to be run; arguments as of `run_cell`."""

    scene: Scene
    design: list[str]
    sizes: Mapping[str, float] | None = None
    both_methods: bool = True

    @property
    def key(self) -> str:
        """Hash of all that the run follows from."""
        sizes = None if self.sizes is None else dict(self.sizes)
        return scene_fingerprint(self.scene, self.design, sizes, self.both_methods)

    def run(self) -> CellOutcome:
        """Run the cell."""
        return run_cell(self.scene, self.design, self.sizes, self.both_methods)


def run_cell(scene: Scene, design: list[str], sizes: Mapping[str, float] | None = None, both_methods: bool = True) -> CellOutcome:
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


def _measured(scene: Scene, design: list[str], sizes: Mapping[str, float] | None, both_methods: bool) -> CellOutcome:
    try:
        system = prepare(scene, design)
        solution = simulate(system, _without_limit(scene), progress=None if scene.solver.local_error is None else _patience())
        responses, gradients = evaluate_with_gradients(solution)
    except (ToolkitError, np.linalg.LinAlgError) as error:
        ending = _ending(error)
        return _without_gradient(scene, ending) if design else CellOutcome(status=ending.status, reason=ending.message)
    values = {name: float(np.real(value)) for name, value in responses.items()}
    found = CellOutcome(
        values=values,
        steps=solution.steps,
        newton_iterations=solution.newton_iterations,
        drift=float(solution.drift),
        created=created_energy(solution),
    )
    if not design:
        return found
    sizes = sizes or {variable.name: typical_size(scene, variable) for variable in system.design}
    slopes = _times(gradients, sizes)
    least = _undecided(scene, values)
    ending, disagreement = _compared_methods(system, solution, slopes, sizes, least) if both_methods else (Ending(), np.nan)
    return replace(found, differentiation=ending, gradients=slopes, disagreement=disagreement, undecided=least)


def _undecided(scene: Scene, values: Mapping[str, float]) -> dict[str, float]:
    """Up to where slopes are round-off: a part of the response, and of the model size or a rad, where it is a place or an angle."""
    sizes, known = {"angle": 1.0, "length": loaded(scene).size}, scene.responses
    own = {name: sizes.get(each.unit_quantity, 0.0) for name, each in known.items() if isinstance(each, Response)}
    return {name: ROUND_OFF * max(abs(value), own.get(name, 0.0)) for name, value in values.items()}


def _without_gradient(scene: Scene, ending: Ending) -> CellOutcome:
    """The run alone: perhaps only its derivatives failed."""
    alone = _measured(scene, [], None, False)
    return replace(alone, differentiation=alone.ending if alone.failed else ending)


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


def _ending(error: Exception) -> Ending:
    refused = isinstance(error, (InputError, ModelFileError))
    return Ending("refused" if refused else "failed", str(error) or type(error).__name__)


def _compared_methods(
    system: System, solution: Solution, slopes: Slopes, sizes: Mapping[str, float], undecided: Mapping[str, float]
) -> tuple[Ending, float]:
    """How the adjoint ended, and how far its slopes are from those of direct differentiation; nan where it has none."""
    try:
        responses, found = adjoint_gradients(system, solution)
    except NeedsDirectError:
        return Ending(), np.nan  # one method is left, and nothing to compare it with
    except ToolkitError as error:
        return Ending("failed", f"adjoint: {error}"), np.nan
    return Ending(), slope_difference(_times(by_name(system.design, responses, found.T), sizes), slopes, undecided)


def _times(gradients: Slopes, sizes: Mapping[str, float]) -> Slopes:
    return {f: {x: slope * sizes[x] for x, slope in row.items()} for f, row in gradients.items()}
