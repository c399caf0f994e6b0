"""Transient analysis: consistent start, the compiled step loop in pieces, and a check of what came out."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from toolkit.equations import allocate_work
from toolkit.errors import ConvergenceError, InputError, SingularSystemError
from toolkit.run_options import RunOptions
from toolkit.solution import Solution
from toolkit.solvers.drift import largest_drift
from toolkit.solvers.generalized_alpha import integrate
from toolkit.solvers.initial_conditions import consistent_start
from toolkit.solvers.newton import CONVERGED, NOT_CONVERGED, SINGULAR
from toolkit.solvers.scheme import Scheme, generalized_alpha
from toolkit.solvers.step_memory import History, Memory, Outcome, allocate_memory
from toolkit.system import System
from toolkit.time_grid import time_grid

GIGABYTE = 1e9
UNSTABILISED = "nothing pulls them back. Leave out solver.baumgarte, or give it a positive stiffness"
PIECE = 200
"""Steps between two reports of progress; long enough that a report costs nothing."""


def simulate(
    system: System,
    options: RunOptions | None = None,
    q: np.ndarray | None = None,
    v: np.ndarray | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Solution:
    """Integrate a scene over time and carry the sensitivities of the system's design variables along.

    Parameters
    ----------
    system : System
    options : RunOptions
        By default the scene's own.
    q, v : (n_q,)
        Start that replaces the scene's, not depending on the design.
    progress : callable
        Called with the steps done and the steps in all.

    Raises
    ------
    InputError, SingularSystemError
        As `consistent_start`; or the step does not fit into the time.
    ConvergenceError
        Newton failed, or the joints drifted apart: names time, equation and remedy.
    """
    begun = clock.perf_counter()
    run = prepare_run(system, options)
    start = consistent_start(system, run.levels, q, v, options=run.options)
    history = allocate_history(system, run.options, len(run.times), start)
    advance(run, history, 0, progress)
    return Solution.from_padded(
        system,
        run.times,
        history[:6],
        drift=check_drift(run, history.q, 0),
        correction=float(run.outcome.correction[1]),
        options=run.options,
        own_start=q is not None or v is not None,
        newton_iterations=int(run.outcome.counts[4]),
        wall={"run": clock.perf_counter() - begun},
    )


class Run(NamedTuple):
    """What all steps of a run share, and what one leaves to the next."""

    system: System
    options: RunOptions
    times: np.ndarray
    levels: np.ndarray
    scheme: Scheme
    memory: Memory
    outcome: Outcome


def prepare_run(system: System, options: RunOptions | None = None) -> Run:
    """Everything but the states; options by default the scene's own."""
    options = options or system.scene.solver
    times = time_grid(options)
    scheme = generalized_alpha(options.scheme, options.rho_inf, times[1] - times[0])
    memory = allocate_memory(system.plan, system.lu_plan, system.weights, system.dtype)
    return Run(system, options, times, constraint_levels(options), scheme, memory, Outcome(np.zeros(5, np.int64), np.zeros(2)))


def advance(run: Run, history: History, first: int, progress: Callable[[int, int], None] | None = None) -> None:
    """Fill a history whose row 0 is the state at step `first`, where `run.memory` stands.

    Raises
    ------
    ConvergenceError, SingularSystemError
        As `simulate`.
    """
    system, options, count = run.system, run.options, len(history.q) - 1
    curves, curves_x = system.curves(run.times[first : first + count + 1])
    for low in range(0, count, PIECE):
        high = min(low + PIECE, count)
        system.run(
            integrate, system.evaluator(), system.plan, system.functions, curves, curves_x, run.levels, run.scheme, system.weights,
            options.tolerance, options.max_iterations, first + low == 0, low, high, history, run.memory, run.outcome,
        )  # fmt: skip
        if run.outcome.counts[0] != CONVERGED:
            raise failure(run, first)
        if progress:
            progress(first + high, len(run.times) - 1)


def constraint_levels(options: RunOptions) -> np.ndarray:
    """Weights (1, 2 damping, stiffness^2) of acceleration, velocity and position in the constraint rows, (3,)."""
    step = time_grid(options)[1]
    damping, stiffness = options.baumgarte.damping, options.baumgarte.stiffness
    damping = 1 / step if damping is None else damping
    stiffness = np.sqrt(2) / step if stiffness is None else stiffness
    return np.array([1.0, 2 * damping, stiffness**2])


def allocate_history(system: System, options: RunOptions, n_t: int, start: tuple) -> History:
    """Memory for all states, the first filled in.

    Raises
    ------
    InputError
        The states need more memory than `solver.memory`.
    """
    needed = 8 * n_t * sum(item.size for item in start)
    if needed > GIGABYTE * options.memory:
        raise InputError(
            f"{n_t} states of {system.n} unknowns with {system.n_x} design variables need {needed / GIGABYTE:.3g} GB, more than "
            f"solver.memory = {options.memory:g} GB. Choose a larger solver.step, a shorter time, or fewer design variables at once; "
            "or the adjoint method, which keeps checkpoints only."
        )
    return empty_history(system, n_t, start)


def empty_history(system: System, n_t: int, start: tuple) -> History:
    """Memory for n_t states, the first filled in."""
    arrays = [np.zeros((n_t, *item.shape), system.dtype if item.ndim == 1 else float) for item in start]
    for array, item in zip(arrays, start, strict=True):
        array[0] = item
    return History(*arrays, *(array.reshape(n_t, -1) for array in arrays[3:]))


def check_drift(run: Run, q: np.ndarray, first: int) -> float:
    """Largest violation of any joint in states (n, ...) from step `first` on, relative to the scene's size or in rad.

    Raises
    ------
    ConvergenceError
        The joints came apart; names joint, time and remedy.
    """
    system, options, times = run.system, run.options, run.times[first : first + len(q)]
    found, curves = np.zeros(3), system.curves(times)[0]
    system.run(
        largest_drift, system.plan, system.functions, curves, system.weights, q, np.zeros(system.n, system.dtype), found,
        allocate_work(system.plan, system.dtype),
    )  # fmt: skip
    if not found[0] <= options.drift_tolerance:
        stabilised = run.levels[2] > 0
        cause = (
            f"the step of {run.times[1]:g} is far too large for this motion. Try a tenth of it" if stabilised else UNSTABILISED
        )
        raise ConvergenceError(
            f"the joints came apart: {system.numbering.names[int(found[2])]} is off by {found[0]:.1e} of the scene's size at "
            f"t = {times[int(found[1])]:g}, more than solver.drift_tolerance = {options.drift_tolerance:g}: {cause}."
        )
    return float(found[0])


def failure(run: Run, first: int) -> Exception:
    """The error that a failed step deserves, in a piece of the run that begins at step `first`."""
    status, step, iterations, worst, _ = (int(count) for count in run.outcome.counts)
    step += first
    name, time, tolerance = run.system.numbering.names[worst], run.times[step + 1], run.options.tolerance
    if status == SINGULAR:
        return SingularSystemError(
            f"the equations do not determine {name} at t = {time:g}: redundant joints, or a mechanism in a singular position. "
            "Remove the redundant joint, or start off the singular position."
        )
    what = f"correction {run.outcome.correction[0]:.1e} > {tolerance:.1e}" if status == NOT_CONVERGED else "not finite"
    return ConvergenceError(
        f"Newton stopped at t = {time:g} (step {step + 1} of {len(run.times) - 1}) after {iterations} iterations: {what}, "
        f"largest in {name}. Try a smaller solver.step (now {run.times[1]:g}) or a smoother load curve."
    )
