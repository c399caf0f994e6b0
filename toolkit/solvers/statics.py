"""Static equilibrium with load stepping along a path that is followed, never jumped."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from typing import Any

import numpy as np

from toolkit.errors import ConvergenceError, CriticalPointError, SingularSystemError
from toolkit.run_options import RunOptions
from toolkit.solution import Solution
from toolkit.solvers.bifurcation import bifurcation
from toolkit.solvers.continuation import Arrival, to_full_load
from toolkit.solvers.critical_state import is_stable, refuse_gradients_of_critical
from toolkit.solvers.direct_solve import solve_linear
from toolkit.solvers.equilibrium import Equilibrium, inputs_at, static_matrix
from toolkit.solvers.load_step import load_step
from toolkit.solvers.modes import solve_modes
from toolkit.solvers.static_start import start_of_path
from toolkit.static_path import StaticPath
from toolkit.system import System
from toolkit.validity.judge import judge

SMALLEST_STEP = 1e-4
"""Part of the load below which a step is not halved any more: what is left goes by arc length."""

Progress = Callable[[int, int], None]
Visited = list[tuple[float, Equilibrium]]


def solve_statics(system: System, options: RunOptions | None = None, progress: Progress | None = None) -> Solution:
    """Equilibrium under the loads at the end time, reached from the undeformed state; with its design derivatives.

    Loads and gravity grow in proportion, drivers move from their first to their last value. The step is halved where Newton
    fails, or where it strays from the tangent of the path. Joints that are open in the given positions are closed first.
    With `options.continuation` "arc-length" the path is followed past limit points; `Solution.path` tells which.

    Raises
    ------
    LimitPointError
        The path turns back before the full load (snap-through), and it is not to be followed further.
    BifurcationError
        The path is unstable from some part of the load on (buckling).
    ConvergenceError
        The path ends before the full load, or the equilibrium is unstable.
    CriticalStateError
        Derivatives are asked for at a limit point or bifurcation.
    SingularSystemError
        Something is free to move, or joints are redundant.
    """
    options = options or system.scene.solver
    begun = clock.perf_counter()
    state, factor, count = start_of_path(system, options)
    follow = _along_path if options.continuation == "arc-length" else _load_stepping
    arrival = follow(system, options, state, factor, progress)
    report = {"newton_iterations": count + arrival.iterations, "load_steps": arrival.steps + (factor > 0), "path": arrival.path}
    solution = _with_sensitivities(system, options, arrival.state, begun, **report)
    if system.compiled:
        _refuse_unstable_end(solution, options)
    return solution


def _along_path(system: System, options: RunOptions, state: Equilibrium, factor: float, progress: Progress | None) -> Arrival:
    return to_full_load(system, options, state, factor, True, progress)


def _load_stepping(system: System, options: RunOptions, state: Equilibrium, factor: float, progress: Progress | None) -> Arrival:
    """Equal steps of the load, halved where they fail; what is left then goes by arc length, up to a limit point."""
    step, count, visited = 1.0 / options.load_steps, 0, [(factor, state)]
    while factor < 1 - 1e-12:
        target = min(1.0, factor + step)
        try:
            state, iterations = load_step(system, options, state, factor, target)
        except ConvergenceError as error:
            step /= 2
            if step < SMALLEST_STEP:
                rest = _last_stretch(system, options, visited, error)
                return rest._replace(iterations=count + rest.iterations)
            continue
        factor, count = target, count + iterations
        visited.append((factor, state))
        if progress:
            progress(round(100 * factor), 100)
    return Arrival(state, _path(system, visited), count, len(visited) - 1)


def _last_stretch(system: System, options: RunOptions, visited: Visited, error: ConvergenceError) -> Arrival:
    """From where load stepping fails: to the full load, or to the limit point before it, which is found precisely."""
    (factor, state), path = visited[-1], _path(system, visited)
    if factor == 0:
        raise _nothing_near(error) from error
    if not is_stable(system, options, state, factor):
        raise bifurcation(system, options, path) or _lost(factor, error) from error
    try:
        rest = to_full_load(system, options, state, factor, past_limits=False)
    except CriticalPointError as critical:
        raise critical from error
    except ConvergenceError as further:
        raise _lost(factor, further) from error
    load_factors, q, multipliers = (
        np.concatenate([getattr(path, name)[:-1], getattr(rest.path, name)]) for name in ("load_factors", "q", "multipliers")
    )
    joined = StaticPath(load_factors, q, multipliers)
    return rest._replace(path=joined, steps=len(visited) - 1 + rest.steps)


def _path(system: System, visited: Visited) -> StaticPath:
    factors, states = zip(*visited, strict=True)
    n_q = system.n_q
    q, multipliers = np.real([state.q[:n_q] for state in states]), np.real([state.acc[n_q:] for state in states])
    return StaticPath(np.array(factors), q, multipliers)


def _nothing_near(error: Exception) -> ConvergenceError:
    return ConvergenceError(
        f"statics finds no equilibrium near the undeformed state, even under {SMALLEST_STEP:g} of the load ({error}). "
        "The loads may be far too large for the supports; look for one that is orders of magnitude off, or a wrong unit."
    )


def _lost(factor: float, error: Exception) -> ConvergenceError:
    return ConvergenceError(
        f"the static path ends at {100 * factor:.6g} % of the load ({error}), and no limit point was found there: a singular "
        "position, or branches that meet. A transient run can go on from there; a smaller load stays below it."
    )


def _refuse_unstable_end(solution: Solution, options: RunOptions) -> None:
    """As `refuse_unstable`, and where the path lost its stability if it went on under more load."""
    try:
        refuse_unstable(solution)
    except ConvergenceError as error:
        where = bifurcation(solution.system, options, solution.path) if solution.path else None
        raise (where or error) from error


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
        raise ConvergenceError(
            f"the equilibrium is unstable: {solution.system.most_moved(modes.shapes[:, 0])} would run away from it (buckling, or a point "
            "past a snap-through). Use less load, add stiffness there, or follow the motion with a transient run."
        )


def _with_sensitivities(system: System, options: RunOptions, state: Equilibrium, begun: float, **report: Any) -> Solution:
    """One more factorization at the end state, one block solve for all design variables."""
    solved = clock.perf_counter()
    rest, n_q, n_x = np.zeros_like(state.q), system.n_q, system.n_x
    dq = np.zeros((system.n, n_x))
    dacc = np.zeros((system.n, n_x))
    if n_x or not system.compiled:  # a complex system exists for a derivative's sake
        refuse_gradients_of_critical(system, options, state)
    if n_x:
        terms = system.evaluate(inputs_at(system, options, 1.0), state.q, rest, state.acc, design=True)
        change = solve_linear(system, static_matrix(system, terms), -(terms.I_x + terms.A_x), "static sensitivities")
        dq[:n_q], dacc[n_q:] = change[:n_q], change[n_q:]
    states = tuple(item[None] for item in (state.q, rest, state.acc, dq, np.zeros_like(dq), dacc))
    wall = {"run": clock.perf_counter() - begun, "sensitivity": clock.perf_counter() - solved}
    return Solution.from_padded(system, np.array([options.end_time]), states, wall=wall, options=options, judge=judge, **report)
