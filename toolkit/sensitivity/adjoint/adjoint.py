"""Gradients by the discrete adjoint: one backward run for all design variables, exact for the discrete equations as the direct method.

    f = f(q_n, v_n, lam_n, x),   df/dx = f_x + sum over steps of mu_n^T R_x + (start's part)

Worth it where variables are many and responses few; `sensitivity.methods` and the command line offer it as a method.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from toolkit.analyses.run_start import known_start
from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.foundation.errors import NeedsDirectError
from toolkit.foundation.processes.one_thread import one_thread
from toolkit.responses.response import Partials
from toolkit.scene.scene import Scene
from toolkit.sensitivity.adjoint.backward_sweep import begin_sweep, end_sweep, sweep, transposition
from toolkit.sensitivity.adjoint.checkpointed import checkpointed_adjoint, fits
from toolkit.sensitivity.clock import Progress, price
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.evaluation import by_name
from toolkit.sensitivity.preparation import ANALYSES, Kind, check_kind, check_names, moving, responses_of, solve
from toolkit.sensitivity.run import Run, run_of
from toolkit.solvers.spin.steady_state import steady_adjoint
from toolkit.solvers.start.initial_conditions import Motion, State
from toolkit.solvers.static.equilibrium import find_equilibrium, inputs_at, static_matrix
from toolkit.solvers.static.stability.critical_state import refuse_gradients_of_critical
from toolkit.solvers.static.static_change import static_change
from toolkit.system.solution import Solution
from toolkit.system.system import System

NO_BACKWARD_RUN = 'stabilised index 2 (solver.formulation = "ggl") has no backward run'


def adjoint(scene: Scene, design: list[str], kind: Kind, progress: Progress | None = None, timed: bool = False) -> Run:
    """Responses with gradients by the discrete adjoint; parameters and errors as `sensitivity.direct.direct`.

    A run whose states exceed `solver.memory` is computed twice, in windows between checkpoints.

    Raises
    ------
    NeedsDirectError
        The formulation has no backward run, or a response needs derivatives of the states.
    """
    check_kind(kind)
    check_names(design)
    return by_adjoint(Compiled(scene, tuple(design)), kind, progress, timed)


def by_adjoint(compiled: Compiled, kind: Kind, progress: Progress | None = None, timed: bool = False) -> Run:
    """Responses of a compiled scene with gradients by the discrete adjoint."""
    scene = compiled.scene
    if not has_adjoint(scene, kind):
        raise NeedsDirectError(NO_BACKWARD_RUN)
    if kind == "transient" and not fits(scene, compiled.primal):
        return replace(checkpointed_adjoint(compiled, progress), repeat=partial(_again_in_windows, scene, compiled.names))
    with watched_compilation() as first:
        solution = ANALYSES[kind](compiled.primal, progress=progress)
    with watched_compilation() as second:
        found, gradient = adjoint_gradients(compiled.full, solution, progress)
    primal = price(first, timed, partial(solve, compiled.primal, kind))
    extra = price(second, timed, partial(adjoint_gradients, compiled.full, solution))
    values, gradients = _named(compiled.full, found, gradient)
    repeat = partial(again_backwards, compiled.primal, compiled.full, known_start(solution))
    return run_of(solution, values, gradients, "adjoint", primal, extra, repeat)


def again_backwards(
    primal: System, system: System, known: Motion | State | None, options: RunOptions
) -> tuple[dict[str, Any], dict[str, dict[str, float]]]:
    """Values of a motion and gradients by the adjoint with other options, of a scene compiled without and with design variables; `known`
    as of `simulate`."""
    return _named(system, *adjoint_gradients(system, simulate(primal, options, known=known)))


def _named(
    system: System, found: dict[str, Partials], gradient: np.ndarray
) -> tuple[dict[str, Any], dict[str, dict[str, float]]]:
    """Values, and gradients (n_x, n_r), by the names of responses and variables."""
    return {name: partials.value for name, partials in found.items()}, by_name(system.design, found, gradient.T)


def _again_in_windows(
    scene: Scene, design: tuple[str, ...], options: RunOptions
) -> tuple[dict[str, Any], dict[str, dict[str, float]]]:
    """The same where the states of the motion may not fit into memory."""
    found = adjoint(scene.model_copy(update={"solver": options}), list(design), "transient")
    return found.values, found.gradients


def has_adjoint(scene: Scene, kind: Kind) -> bool:
    """Whether a run of the scene can be differentiated backwards: all but those in stabilised index 2."""
    return kind == "static" or scene.solver.formulation != "ggl"


@one_thread()
def adjoint_gradients(
    system: System, solution: Solution, progress: Progress | None = None
) -> tuple[dict[str, Partials], np.ndarray]:
    """Partials of all responses of the scene, and their gradients (n_x, n_r).

    Parameters
    ----------
    system : System
        The scene compiled with the design variables.
    solution : Solution
        Of the same scene, with all states; derivatives in it only tell whether a length that is zero would grow.
    progress : callable
        Called with the steps done and the steps in all.

    Raises
    ------
    SingularSystemError
        A step's transposed equations have no unique solution.
    NeedsDirectError
        A response needs the states' own derivatives (a length that is zero), the run had a start of its own, or its formulation has no
        backward run.
    """
    options = solution.options or system.scene.solver
    if moving(solution) and options.formulation == "ggl":
        raise NeedsDirectError(NO_BACKWARD_RUN)
    if moving(solution) and solution.own_start:
        raise NeedsDirectError("the run has a start of its own, whose derivatives are unknown to the adjoint")
    seen = replace(solution, system=system)
    found = {name: response.partials(seen) for name, response in responses_of(system.scene, moving(solution)).items()}
    if not found:
        return found, np.zeros((system.n_x, 0))
    through = _through_time if moving(solution) else _through_steady_spin if solution.spins else _through_equilibrium
    return found, through(system, solution, list(found.values()), progress)


def _through_time(system: System, solution: Solution, found: list[Partials], progress: Progress | None) -> np.ndarray:
    """Backwards through all steps, then through the consistent start."""
    last = solution.steps
    state = begin_sweep(system, solution.options or system.scene.solver, solution.times, len(found))
    sweep(state, solution, 0, found, (lambda step: progress(last - step, last)) if progress else lambda _: None)
    return end_sweep(state)


def _through_steady_spin(system: System, solution: Solution, found: list[Partials], _: Progress | None) -> np.ndarray:
    """One transposed solve, see `steady_adjoint`."""
    sizes = {"q": system.n_q, "v": system.n_q, "a": system.n_q, "multipliers": system.n - system.n_q}
    parts = [[getattr(each, name) for each in found] for name in sizes]
    by = np.vstack(
        [
            np.column_stack([np.zeros(size) if slope is None else np.real(slope[0]) for slope in slopes])
            for size, slopes in zip(sizes.values(), parts, strict=True)
        ]
    )
    design = [np.zeros(system.n_x) if each.design is None else np.real(each.design) for each in found]
    options = solution.options or system.scene.solver
    return np.column_stack(design) + steady_adjoint(system, options, solution.q[0], solution.multipliers[0], by)


def _through_equilibrium(system: System, solution: Solution, found: list[Partials], _: Progress | None) -> np.ndarray:
    """A^T mu = - f_[q; lam], df/dx = f_x + (I_x + A_x)^T mu."""
    n_q, options = system.n_q, solution.options or system.scene.solver
    load, gradient = np.zeros((system.n, len(found))), np.zeros((system.n_x, len(found)))
    for r, partials in enumerate(found):
        load[:n_q, r] = 0 if partials.q is None else partials.q[0]
        load[n_q:, r] = 0 if partials.multipliers is None else partials.multipliers[0]
        gradient[:, r] = 0 if partials.design is None else partials.design
    q, rest = np.append(solution.q[0], np.zeros(system.n - n_q)), np.zeros(system.n)
    acc = np.append(np.zeros(n_q), solution.multipliers[0])
    refuse_gradients_of_critical(system, options, find_equilibrium(system, options, 1.0, q, acc)[0])
    inputs = inputs_at(system, options, 1.0)
    terms = system.evaluate(inputs, q, rest, acc, design=True)
    places = transposition(system)
    mu = static_change(system, inputs, q, acc, static_matrix(system, terms)[places], -load, "static adjoint", places)
    return gradient + (terms.I_x + terms.A_x).T @ mu
