"""All methods for gradients behind one call.

Which exact method is cheaper, by a model of what both cost per time step beside the run itself.

    direct:   evaluation of the design partials, and per variable a solve and products with the derivatives by the state
    adjoint:  the linearised equations again and their factors, evaluation of the design partials, and per response a transposed solve

The work is counted from the compiled scene. Its price was measured on a wing and chains of 10 to 1000 unknowns, with 1 to 600 variables and
1 to 20 responses, in time of the processor, where the choice was the better method or at most a tenth slower. `python -m
tests.benchmarks.method_choice` measures it again; on another machine all prices change together, so that the choice stays.

Numbers of floating frames that gradients need, where a scene leaves them to be chosen: more than its values need.

Starting with those for the values, gradients are compared with those of twice as many frames. That predicts the number with which they are
off by no more than the verdict allows; with this they are compared again.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from toolkit.analyses.sensitivity.adjoint import by_adjoint
from toolkit.analyses.sensitivity.chosen_frames import Choices, Frames
from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.direct import by_direct, by_repetition, enriched
from toolkit.analyses.sensitivity.preparation import Kind, Progress, check_kind, check_names, frozen, responses_of, variable_sizes
from toolkit.analyses.sensitivity.run import Run
from toolkit.description.run_options import time_grid
from toolkit.foundation.errors import NeedsDirectError
from toolkit.foundation.itself import Itself
from toolkit.foundation.memory_sizes import GIGABYTE, in_gigabytes
from toolkit.responses.extremes import at_peaks
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import System
from toolkit.validity.bodies.deformation import LIMIT

DIRECT = np.array([2.1, 0.12, 0.00054, 0.00014])
"""Price in us of the parts of `direct_work`."""
ADJOINT = np.array([2.3, 0.137, 0.0094, 0.0011])
"""Price in us of the parts of `adjoint_work`."""


def choose(compiled: Compiled, kind: Kind, keep_states: bool = False) -> tuple[str, str]:
    """The cheaper exact method for a run, or the only one that can do it, and the sentence that says why.

    Parameters
    ----------
    keep_states : bool
        Whether derivatives of the states are wanted too, which only direct differentiation has.
    """
    if keep_states:
        return "direct", "direct differentiation, because derivatives of the states are to be kept, which the adjoint has not."
    if kind == "static":
        return "direct", "direct differentiation, because an equilibrium costs one more solve by either method."
    scene, system = compiled.scene, compiled.full
    key = (
        "method",
        Itself(scene.solver),
        Itself(scene.responses),
        system.n,
        system.n_x,
        _entries(system),
        len(system.plan.touched_row),
    )
    if key not in compiled.decided:
        compiled.decided[key] = _cheaper_of_motion(compiled, scene, system)
    found: tuple[str, str] = compiled.decided[key]
    return found


def _cheaper_of_motion(compiled: Compiled, scene: Scene, system: System) -> tuple[str, str]:
    """The cheaper exact method for a motion whose derivatives of the states need not be kept."""
    needed = 8 * len(time_grid(scene.solver)) * (3 * system.n + system.n_x * (2 * system.n_q + system.n))
    if scene.solver.local_error is None and needed > GIGABYTE * scene.solver.memory:
        return "adjoint", f"the adjoint, because derivatives of all states would take {in_gigabytes(needed)}."
    n_r = len(responses_of(scene))
    by_direct, by_adjoint = direct_work(system, n_r) @ DIRECT, adjoint_work(system, n_r) @ ADJOINT
    method, name = ("adjoint", "the adjoint") if by_adjoint < by_direct else ("direct", "direct differentiation")
    part = min(by_direct, by_adjoint) / max(by_direct, by_adjoint)
    counts = f"{counted(len(compiled.names), 'design variable')} and {counted(n_r, 'response')}"
    return method, f"{name}, estimated at {100 * part:.0f} % of the other exact method's price for {counts}."


def counted(number: int, word: str) -> str:
    """A number and a word in its singular or plural."""
    return f"{number} {word}{'s' * (number != 1)}"


def direct_work(system: System, n_r: int) -> np.ndarray:
    """Work of a step of direct differentiation: unknowns, equations per variable, and unknowns per variable and response."""
    return np.array([1, system.n, system.n_x * _entries(system), n_r * system.n_x * system.n])


def adjoint_work(system: System, n_r: int) -> np.ndarray:
    """Work of a step of the adjoint: unknowns, design partials, and equations per response."""
    return np.array([1, system.n, len(system.plan.touched_row), n_r * _entries(system)])


def _entries(system: System) -> int:
    """Number of entries of the equations' sparsity pattern and of their factors."""
    return len(system.plan.indices) + int(system.lu_plan.row_start[-1])


def gradients_by(
    method: str,
    scene: Scene,
    design: list[str],
    kind: Kind,
    progress: Progress | None = None,
    keep_states: bool = False,
    timed: bool = False,
) -> Run:
    """Responses with gradients by a method of `method_names.METHODS`.

    "direct" costs little per variable, "adjoint" next to nothing per variable but a backward run for all responses together, "auto" takes
    the cheaper of the two and says why in the result's `reason`; the numerical methods run the whole analysis for every variable.
    `keep_states`: "auto" shall provide derivatives of the states too.

    Raises
    ------
    InputError
        The method is unknown.
    """
    check_kind(kind)
    check_names(design)
    return by_method(method, Compiled(scene, tuple(design)), kind, progress, keep_states, timed)


def by_method(
    method: str,
    compiled: Compiled,
    kind: Kind,
    progress: Progress | None = None,
    keep_states: bool = False,
    timed: bool = False,
) -> Run:
    """Responses with gradients of a compiled scene, by a method of `method_names.METHODS`."""
    chosen, reason = choose(compiled, kind, keep_states) if method == "auto" else (method, "")
    try:
        if chosen in DIFFERENTIATED:
            found = DIFFERENTIATED[chosen](compiled, kind, progress, timed)
        else:
            found = by_repetition(compiled, kind, method, progress, timed=timed)
    except NeedsDirectError as refusal:
        if method != "auto":
            raise
        found, reason = by_direct(compiled, kind, progress, timed), f"direct differentiation, because {refusal.why}."
    return replace(
        found,
        reason=reason,
        reframed=partial(_reframed, compiled, kind, found.solution),
        enriched=partial(enriched, compiled, kind, found.solution, partial(by_method, "auto")),
    )


DIFFERENTIATED = {"direct": by_direct, "adjoint": by_adjoint}
"""Exact method -> function that solves a scene with gradients by it."""


def _reframed(
    compiled: Compiled, kind: Kind, solution: Solution, frames: Mapping[str, Frames]
) -> tuple[Mapping[str, float], Mapping[str, Mapping[str, float]]]:
    """Values and gradients, those of extremes at peaks between the steps, of a compiled scene with other frames and the same steps."""
    other = compiled.reframed(frames, reduced=True)
    if kind == "transient" and (compiled.scene.solver.local_error is not None or solution.halved):
        other = Compiled(frozen(other.scene, solution, compiled.scene.solver.halvings), other.names)
    found = by_method("auto", other, kind)
    return found.values, at_peaks(found.gradients, found.solution)


PREDICTION_ROUNDS = 4
"""Predictions; what is off then, by bodies whose number is written, the verdict of the run says."""


def with_frames_for_gradients(scene: Scene, kind: Kind, names: Iterable[str]) -> Scene:
    """The scene with the numbers of frames that an analysis and its gradients by some variables need; itself if none is to be chosen.

    Raises
    ------
    InputError, ConvergenceError, SingularSystemError
        As of `chosen_frames`.
    """
    names = tuple(names)
    return Compiled(scene, names).analysed_by(kind, more_frames if names else None).scene


def more_frames(compiled: Compiled, kind: Kind, choices: Choices) -> Choices:
    """Body -> number of frames for values and gradients, from the numbers for the values of a scene."""
    for _ in range(PREDICTION_ROUNDS):
        found = by_method("auto", compiled.chosen(choices), kind)
        errors = found.frame_errors
        if errors is None or errors.failure:
            return choices
        worst = errors.largest(found.gradients, variable_sizes(compiled.scene, found))
        advised = {
            body: number for body, number in errors.advised(worst).items() if body in choices and not choices[body][1].kept_run
        }
        choices = _noted(choices, {body: (choices[body][0], worst) for body in advised})
        if worst <= LIMIT or not advised:
            return choices
        choices = {body: (advised.get(body, number), choice) for body, (number, choice) in choices.items()}
    return choices


def _noted(choices: Choices, tried: dict[str, tuple[int, float]]) -> Choices:
    """Choices that remember what was tried."""
    return {
        body: (number, choice._replace(gradients=(*choice.gradients, tried[body])) if body in tried else choice)
        for body, (number, choice) in choices.items()
    }
