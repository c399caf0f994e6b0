"""Static equilibrium with load stepping along a path that is followed, never jumped."""

from __future__ import annotations

import time as clock
from collections.abc import Callable

import numpy as np

from toolkit.errors import ConvergenceError, SingularSystemError
from toolkit.run_options import RunOptions
from toolkit.solution import Solution
from toolkit.solvers.direct_solve import solve_linear
from toolkit.solvers.equilibrium import Equilibrium, find_equilibrium, inputs_at, static_matrix
from toolkit.solvers.modes import solve_modes
from toolkit.solvers.static_start import start_of_path
from toolkit.system import System

SMALLEST_STEP = 1e-4
"""Part of the load below which a step is not halved any more: the path ends there, at a limit point or bifurcation."""
FREE_CORRECTION, TRUSTED_CORRECTION = 1e-3, 0.5
"""Newton may move a predicted state by this part of the scene's size, or by this part of the predictor; more would be a jump."""


def solve_statics(
    system: System, options: RunOptions | None = None, progress: Callable[[int, int], None] | None = None
) -> Solution:
    """Equilibrium under the loads at the end time, reached from the undeformed state; with its design derivatives.

    Loads and gravity grow in proportion, drivers move from their first to their last value. The step is halved where Newton
    fails, or where it strays from the tangent of the path. Joints that are open in the given positions are closed first.

    Raises
    ------
    ConvergenceError
        The path ends before the full load: a limit point (snap-through) or an unstable equilibrium.
    SingularSystemError
        Something is free to move, or joints are redundant.
    """
    options = options or system.scene.solver
    begun = clock.perf_counter()
    state, factor, count = start_of_path(system, options)
    step, accepted = 1.0 / options.load_steps, int(factor > 0)
    while factor < 1 - 1e-12:
        target = min(1.0, factor + step)
        try:
            state, iterations = _advance(system, options, state, factor, target)
        except ConvergenceError as error:
            step /= 2
            if step < SMALLEST_STEP:
                raise _end_of_path(factor, error) from error
            continue
        factor, count, accepted = target, count + iterations, accepted + 1
        if progress:
            progress(round(100 * factor), 100)
    solution = _with_sensitivities(system, options, state, begun, newton_iterations=count, load_steps=accepted)
    if system.compiled:
        refuse_unstable(solution)
    return solution


def _end_of_path(factor: float, error: Exception) -> ConvergenceError:
    if factor == 0:
        return ConvergenceError(
            f"statics finds no equilibrium near the undeformed state, even under {SMALLEST_STEP:g} of the load ({error}). "
            "The loads may be far too large for the supports; look for one that is orders of magnitude off, or a wrong unit."
        )
    return ConvergenceError(
        f"the static path ends at {100 * factor:.1f} % of the load ({error}). There is a limit point or an unstable "
        "equilibrium: a transient run with a fine step can follow the snap-through; a smaller load stays below it."
    )


def refuse_unstable(solution: Solution) -> None:
    """Refuse an equilibrium that the smallest disturbance ends: the square of some frequency is negative.

    Raises
    ------
    ConvergenceError
        The equilibrium is unstable; names the coordinate that would run away.
    """
    try:
        modes = solve_modes(solution, 1)
    except SingularSystemError:
        return  # nothing can move, or following forces make it flutter, which is no matter of statics
    if modes.frequencies[0] < 0:
        worst = int(np.argmax(np.abs(modes.shapes[:, 0]) * solution.system.weights[: len(modes.shapes)]))
        raise ConvergenceError(
            f"the equilibrium is unstable: {solution.system.numbering.names[worst]} would run away from it (buckling, or a point "
            "past a snap-through). Use less load, add stiffness there, or follow the motion with a transient run."
        )


def _advance(system: System, options: RunOptions, state: Equilibrium, factor: float, target: float) -> tuple[Equilibrium, int]:
    """Follow the tangent to the next load factor, then correct."""
    n_q, step = system.n_q, (target - factor) * state.tangent
    moved = np.where(np.arange(system.n) < n_q, step, 0)
    reach = (system.weights * np.abs(np.real(moved)))[:n_q].max(initial=0)
    allowed = FREE_CORRECTION + TRUSTED_CORRECTION * reach
    try:
        return find_equilibrium(system, options, target, state.q + moved, state.acc + step - moved, allowed)
    except SingularSystemError as error:
        raise ConvergenceError(str(error)) from error


def _with_sensitivities(system: System, options: RunOptions, state: Equilibrium, begun: float, **report: int) -> Solution:
    """One more factorization at the end state, one block solve for all design variables."""
    solved = clock.perf_counter()
    rest, n_q, n_x = np.zeros_like(state.q), system.n_q, system.n_x
    dq = np.zeros((system.n, n_x))
    dacc = np.zeros((system.n, n_x))
    if n_x:
        terms = system.evaluate(inputs_at(system, options, 1.0), state.q, rest, state.acc, design=True)
        change = solve_linear(system, static_matrix(system, terms), -(terms.I_x + terms.A_x), "static sensitivities")
        dq[:n_q], dacc[n_q:] = change[:n_q], change[n_q:]
    states = tuple(item[None] for item in (state.q, rest, state.acc, dq, np.zeros_like(dq), dacc))
    wall = {"run": clock.perf_counter() - begun, "sensitivity": clock.perf_counter() - solved}
    return Solution.from_padded(system, np.array([options.end_time]), states, wall=wall, options=options, **report)
