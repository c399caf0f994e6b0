"""Static equilibrium with load stepping along a path that is followed, never jumped.

Free motions as states that can be drawn: the given positions, and each motion that nothing holds.

Each motion moves its bodies by a tenth of the model size.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable

import numpy as np

from toolkit.analyses.modes import solve_modes, solve_spinning
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import BifurcationError, ConvergenceError, InputError, SingularSystemError
from toolkit.foundation.near_ties import told_apart
from toolkit.foundation.processes import one_thread
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.solvers.direct_solve import check_dense
from toolkit.solvers.half_turns import half_turn
from toolkit.solvers.static.continuation import FULL_LOAD_MOVE, to_full_load
from toolkit.solvers.static.critical_state import is_stable, refuse_gradients_of_critical
from toolkit.solvers.static.equilibrium import (
    Equilibrium,
    find_equilibrium,
    inputs_at,
    loose_motions,
    refuse_open_joints_left_out,
    static_change,
    static_matrix,
)
from toolkit.solvers.static.passed_limits import at_limit_position
from toolkit.solvers.static.static_start import start_of_path
from toolkit.system.solution import Solution, StaticPath
from toolkit.system.system import System
from toolkit.validity.equilibrium import bifurcation_of_frame
from toolkit.validity.judge import judge

Progress = Callable[[int, int], None]


LOAD_PART_BEFORE_BIFURCATION = 0.9
"""Part of the load of a bifurcation at which its reason is looked for."""
DIRECT_NEWTON_DISTANCE = 0.05
"""Part of the model size (or rad) that an equilibrium may be off that of another design from which Newton goes straight to it."""


@one_thread()
def solve_statics(
    system: System, options: RunOptions | None = None, progress: Progress | None = None, start: Solution | None = None
) -> Solution:
    """Equilibrium under the loads at the end time, reached from the undeformed state; with its design derivatives.

    For `options.equilibrium` "spinning" it is the steady state of a scene that spins, see `solve_spinning`.

    Loads and gravity grow in proportion, drivers move from their first to their last value. Steps are shortened until nothing can hide
    between them (see `path_steps`). Joints that are open in the given positions are closed first.
    With `options.continuation` "arc-length" the path is followed past limit points; `Solution.path` tells which.

    Parameters
    ----------
    system
        The compiled scene.
    options
        By default the scene's own.
    progress
        Called with the steps done and the steps in all.
    start
        An equilibrium of the same scene at other numbers; not used for `continuation` "arc-length", where the path decides which one is
        meant. If Newton goes straight from there to a stable one close by, the path from the
        unloaded state is not followed, and the verdict says so; otherwise it is.

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
    InputError
        The matrices, which are dense, do not fit into `solver.memory`.
    """
    options = options or system.scene.solver
    if options.equilibrium == "spinning":
        return solve_spinning(system, options, known=start)
    check_dense(system, options)
    if start is not None and options.continuation == "load" and (near := _equilibrium_near(system, options, start)):
        state, count = near
        return _with_sensitivities(system, options, state, count, own_start=True)
    state, factor, count = start_of_path(system, options)
    try:
        arrival = to_full_load(system, options, state, factor, options.continuation == "arc-length", progress)
    except (ConvergenceError, SingularSystemError) as error:
        told = at_limit_position(system, options, state.q, factor, error)
        if isinstance(told, BifurcationError):
            told = _explained(system, options, state, told)
        if told is error:
            raise
        raise told from error
    _refuse_half_turns(system, options, arrival.path)
    refuse_open_joints_left_out(system, options, arrival.state.q)
    iterations, load_steps = count + arrival.iterations, arrival.steps + (factor > 0)
    return _with_sensitivities(system, options, arrival.state, iterations, load_steps, arrival.path)


def _explained(system: System, options: RunOptions, state: Equilibrium, error: BifurcationError) -> BifurcationError:
    """Error of a path that began without loads, with its reason where that is no buckling."""
    try:
        before, _ = find_equilibrium(system, options, LOAD_PART_BEFORE_BIFURCATION * error.load_factor, state.q, state.acc)
    except (ConvergenceError, SingularSystemError):
        return error
    rest, none = np.zeros_like(before.q)[None], np.zeros((1, system.n, 0))
    states = (before.q[None], rest, before.acc[None], none, none, none)
    return bifurcation_of_frame(Solution.from_padded(system, np.array([options.end_time]), states, options=options), error)


def equilibrium_beside(system: System, known: Solution) -> Solution:
    """The equilibrium of a scene whose numbers differ from those of a known one by nothing but a complex step.

    The equilibrium follows from its equations alone, whatever the path that led there: Newton goes on from the known one in complex
    numbers, and the path is not followed a second time as plain Python.

    Parameters
    ----------
    system : System
        The scene with the complex number.
    known : Solution
        Of `solve_statics`, for the scene without it.

    Raises
    ------
    CriticalStateError
        The known equilibrium is a limit point or bifurcation, where there are no derivatives.
    ConvergenceError, SingularSystemError
        The equations have no solution there, or more than one.
    """
    options = known.options or system.scene.solver
    if known.spins:
        return solve_spinning(system, options, known=known)
    q: np.ndarray = np.zeros(system.n, system.dtype)
    acc: np.ndarray = np.zeros(system.n, system.dtype)
    q[: system.n_q], acc[: system.n_q], acc[system.n_q :] = known.q[-1], known.a[-1], known.multipliers[-1]
    state, count = find_equilibrium(system, options, 1.0, q, acc, FULL_LOAD_MOVE)
    return _with_sensitivities(system, options, state, count, path=known.path)


def _equilibrium_near(system: System, options: RunOptions, known: Solution) -> tuple[Equilibrium, int] | None:
    """A stable equilibrium close to a known one, and Newton's iterations; None if there is none, or a spring turned half round."""
    if known.q.shape[1] != system.n_q or len(known.times) != 1:
        raise InputError("a start of statics is an equilibrium of the same scene. Give what `statics` has returned.")
    free = np.zeros(system.n - system.n_q)
    try:
        q, acc = np.append(known.q[-1], free), np.append(np.zeros(system.n_q), known.multipliers[-1])
        state, count = find_equilibrium(system, options, 1.0, q, acc, DIRECT_NEWTON_DISTANCE)
    except (ConvergenceError, SingularSystemError):
        return None
    values = inputs_at(system, options, 1.0).curves
    stable = (
        is_stable(system, options, state, 1.0)
        and half_turn(system, np.stack([q, state.q]), lambda: np.stack([values] * 2)) is None
    )
    return (state, count) if stable else None


def _refuse_half_turns(system: System, options: RunOptions, path: StaticPath) -> None:
    q: np.ndarray = np.pad(path.q, ((0, 0), (0, system.n - system.n_q))).astype(system.dtype)
    found = half_turn(system, q, lambda: np.stack([inputs_at(system, options, factor).curves for factor in path.load_factors]))
    if found:
        raise ConvergenceError(f"{found[0]} at {100 * path.load_factors[found[2]]:.4g} % of the load: {found[1]}")


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


def _with_sensitivities(
    system: System,
    options: RunOptions,
    state: Equilibrium,
    newton_iterations: int,
    load_steps: int = 0,
    path: StaticPath | None = None,
    own_start: bool = False,
) -> Solution:
    """Static solution with its design derivatives, from one more factorization at the end state and one block solve."""
    solved = clock.perf_counter()
    rest, n_q, n_x = np.zeros_like(state.q), system.n_q, system.n_x
    dq = np.zeros((system.n, n_x))
    dacc = np.zeros((system.n, n_x))
    if n_x or not system.compiled:  # a complex system exists for a derivative's sake
        refuse_gradients_of_critical(system, options, state)
    if n_x:
        inputs = inputs_at(system, options, 1.0)
        terms = system.evaluate(inputs, state.q, rest, state.acc, design=True)
        matrix, forces = static_matrix(system, terms), -(terms.I_x + terms.A_x)
        change = static_change(system, inputs, state.q, state.acc, matrix, forces, "static sensitivities")
        dq[:n_q], dacc[n_q:] = change[:n_q], change[n_q:]
    states = tuple(item[None] for item in (state.q, rest, state.acc, dq, np.zeros_like(dq), dacc))
    return Solution.from_padded(
        system,
        np.array([options.end_time]),
        states,
        options=options,
        judge=judge,
        newton_iterations=newton_iterations,
        load_steps=load_steps,
        path=path,
        own_start=own_start,
        sensitivity_seconds=clock.perf_counter() - solved,
    )


DRAWN_DISTANCE = 0.1
"""Distance that a motion is drawn by, in parts of the model size or rad."""


def free_motion_states(system: System, frames: int = 1) -> Solution:
    """The given positions, and behind them those moved along every free motion; each with its name.

    Where several motions are free, each mixture of them is free too: they are told apart as modes of equal frequency are.

    Parameters
    ----------
    frames : states of every motion: the farthest alone, or a whole number of fours for a swing there, back, to the other side and home

    Raises
    ------
    InputError
        Joints and stiffness hold every body.
    """
    motions = loose_motions(system, system.scene.solver)
    count, n_q = motions.shape[1], system.n_q
    if not count:
        raise InputError("nothing can move freely: joints and stiffness hold every body. Leave --free-motions out.")
    weights = system.weights[: system.n_b]
    shapes = told_apart(np.zeros(count), motions, weights)
    shapes = DRAWN_DISTANCE * shapes / (weights[:, None] * np.abs(shapes)).max(axis=0)
    swing = np.sin(2 * np.pi * np.arange(1, frames + 1) / frames) if frames > 1 else np.ones(1)
    q = np.tile(np.real(system.undeformed()[0][:n_q]), (1 + count * frames, 1))
    q[1:, : system.n_b] += np.kron(shapes.T, swing[:, None])
    rest, force = np.zeros_like(q), np.zeros((len(q), system.n - n_q))
    design = (*q.shape, system.n_x)
    names = ("as given", *(f"free motion {k + 1} of {count}" for k in range(count) for _ in range(frames)))
    nothing, no_force = np.zeros(design), np.zeros((*force.shape, system.n_x))
    times = np.arange(float(len(q)))
    return Solution(system, times, q, rest, rest, force, nothing, nothing, nothing, no_force, judge=_judged, names=names)


def farthest(solution: Solution, frames: int) -> list[float]:
    """Times of the given positions and of the farthest state of every motion of `free_motion_states`."""
    return [float(solution.times[0]), *map(float, solution.times[max(frames // 4, 1) :: frames])]


def _judged(_solution: Solution) -> Verdict:
    text = "these are motions that nothing resists while there are no loads, each a tenth of the model size or rad far."
    return Verdict.of([Caution("free-motions", text, doubt=False)])
