"""Cells of a map: their jobs, their outcomes, and what each is called.

A run is
    failed       if it raised an error: Newton did not converge, or the equations of a step are singular;
    refused      if the scene cannot be set up there, for example a reduced model that knows no other thickness;
    drifting     if it ended, but its joints opened further than `drift`, or it created more energy than `energy`;
    inaccurate   if it ended in good order, but a response differs from the reference by more than `accuracy`;
    stable       otherwise.

Why these. An error and open joints are what the solver itself can see. Energy is the norm in which a scheme is stable or not: a scheme
that creates energy out of nothing grows without bound if it runs on, one that loses some does not, so only what was created counts,
beyond the error of the sum that measures the work. All of this can be in order and the motion wrong: after a singular position the
mechanism may have taken the other branch, a step may have jumped over a snap-through. Only a comparison sees that, and `accuracy` is
coarse on purpose: it tells another motion from the same motion with an error, which is what `ffrf tradeoff` measures.

A gradient has the same names: failed and refused if it could not be computed, drifting where its run drifts, inaccurate if direct
differentiation and the adjoint differ by more than `agreement`, or if it is further than `accuracy` from the gradient of the reference.
Both methods are exact for the same discrete equations, so whatever they differ by is round-off that grew: half the digits of double
precision are the least that an optimiser can use.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import count
from typing import Literal, NamedTuple

import numpy as np

from toolkit.analyses.sensitivity.adjoint import adjoint_gradients
from toolkit.analyses.sensitivity.direct import typical_size
from toolkit.analyses.sensitivity.preparation import by_name, evaluate_with_gradients, prepare
from toolkit.analyses.transient import simulate
from toolkit.foundation.errors import ConvergenceError, InputError, ModelFileError, NeedsDirectError, ToolkitError
from toolkit.responses.response import Response
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.studies.store import RunOutcome, scene_fingerprint
from toolkit.system.solution import Solution
from toolkit.system.system import System
from toolkit.validity.energy_balance import created_energy

Status = Literal["ended", "failed", "refused"]
Slopes = dict[str, dict[str, float]]


class Ending(NamedTuple):
    """How a run, or the differentiation of one, ended; the error's text if it did not."""

    status: Status = "ended"
    message: str = ""


@dataclass(frozen=True, kw_only=True)
class CellOutcome(RunOutcome):
    """A cell that was run; `reason` says why it did not end, and may go with other numbers that are known.

    Attributes
    ----------
    status
        How the run ended.
    differentiation
        How its differentiation ended; None if there are no variables.
    gradients
        Response -> variable -> derivative times the size of the variable, so that all slopes of a response are comparable.
    created
        `created_energy`.
    disagreement
        Largest difference of direct differentiation and adjoint, over the largest slope of each response.
    undecided
        Response -> up to where its slopes may be round-off.
    """

    status: Status = "ended"
    differentiation: Ending | None = None
    created: float = 0.0
    disagreement: float = 0.0
    undecided: dict[str, float] = field(default_factory=dict)

    @property
    def ending(self) -> Ending:
        """How the run ended."""
        return Ending(self.status, self.reason)


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


def value_difference(one: CellOutcome, other: CellOutcome) -> float:
    """Largest difference of responses, each over what it is in `other` or over what a variable's own size changes there."""
    largest = 0.0
    for f, value in other.values.items():
        scale = max([abs(value), *(abs(s) for s in other.gradients.get(f, {}).values() if np.isfinite(s))])
        largest = max(largest, _ratio(abs(one.values[f] - value), scale))
    return largest


def _ratio(difference: float, scale: float) -> float:
    """Relative difference; nan and the change of a zero are infinite."""
    if difference == 0:
        return 0.0
    found = difference / scale if scale > 0 else np.inf
    return float(found) if np.isfinite(found) else np.inf


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


CLASSES = ("stable", "inaccurate", "drifting", "failed", "refused", "not run")


@dataclass(frozen=True)
class Limits:
    """Where one class ends and the next begins; all relative."""

    drift: float = 1e-3
    energy: float = 0.05
    accuracy: float = 0.1
    agreement: float = 1e-6


@dataclass(frozen=True)
class CellClass:
    """Class of a cell, and what decided it."""

    name: str
    reason: str = ""


def run_class(cell: CellOutcome, reference: CellOutcome | None, limits: Limits) -> CellClass:
    """Class of a run; without a reference its accuracy is not judged."""
    return _ended(cell.ending) or _drifting(cell, limits) or _compared(cell.ending, cell, reference, value_difference, limits)


def gradient_class(cell: CellOutcome, reference: CellOutcome | None, limits: Limits) -> CellClass | None:
    """Class of a gradient; None if there are no variables."""
    if cell.differentiation is None and not cell.failed:
        return None
    ending = cell.differentiation or cell.ending
    return (
        _ended(ending)
        or _drifting(cell, limits)
        or _disagreeing(cell, limits)
        or _compared(
            ending, cell, reference, lambda one, other: slope_difference(one.gradients, other.gradients, other.undecided), limits
        )
    )


def _ended(ending: Ending) -> CellClass | None:
    return None if ending.status == "ended" else CellClass(ending.status, ending.message)


def _drifting(cell: CellOutcome, limits: Limits) -> CellClass | None:
    if not cell.drift <= limits.drift:
        return CellClass("drifting", f"joints open by {cell.drift:.1e} of the model size, more than {limits.drift:g}")
    if not cell.created <= limits.energy:
        return CellClass("drifting", f"energy created: {100 * cell.created:.3g} % of the largest energy or work")
    return None


def _disagreeing(cell: CellOutcome, limits: Limits) -> CellClass | None:
    if cell.disagreement > limits.agreement:
        return CellClass("inaccurate", f"direct differentiation and adjoint differ by {cell.disagreement:.1e}")
    if any(np.isinf(slope) for row in cell.gradients.values() for slope in row.values()):
        return CellClass("inaccurate", "a derivative is infinite")
    return None


def _compared(
    ending: Ending,
    cell: CellOutcome,
    reference: CellOutcome | None,
    difference: Callable[[CellOutcome, CellOutcome], float],
    limits: Limits,
) -> CellClass:
    if reference is None:
        return CellClass("stable")
    there = reference.ending if reference.failed else (reference.differentiation or ending)
    if there.status != "ended":
        return CellClass("inaccurate", f"with half the step: {there.message}")
    off = difference(cell, reference)
    if off > limits.accuracy:
        return CellClass("inaccurate", f"off by {100 * off:.3g} % of the reference")
    return CellClass("stable", f"off by {100 * off:.2g} % of the reference")
