"""Transient analysis: consistent start, the compiled step loop in pieces, and a check of what came out."""

from __future__ import annotations

import time as clock
from collections.abc import Callable

import numpy as np

from toolkit.equations import allocate_work
from toolkit.errors import ConvergenceError, InputError, SingularSystemError
from toolkit.run_options import RunOptions
from toolkit.solution import Solution
from toolkit.solvers.drift import largest_drift
from toolkit.solvers.generalized_alpha import integrate
from toolkit.solvers.initial_conditions import consistent_start
from toolkit.solvers.newton import CONVERGED, NOT_CONVERGED, SINGULAR
from toolkit.solvers.scheme import generalized_alpha
from toolkit.solvers.step_memory import History, Outcome, allocate_memory
from toolkit.system import System
from toolkit.time_grid import time_grid

MOST_MEMORY = 8e9
"""Bytes of all states with their derivatives, beyond which a machine would swap, not simulate."""
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
    options = options or system.scene.solver
    begun = clock.perf_counter()
    times = time_grid(options)
    levels = constraint_levels(options)
    start = consistent_start(system, levels, q, v, options=options)
    history = allocate_history(system, len(times), start)
    scheme = generalized_alpha(options.scheme, options.rho_inf, times[1] - times[0])
    curves, curves_x = system.curves(times)
    memory, outcome = (
        allocate_memory(system.plan, system.lu_plan, system.weights, system.dtype),
        Outcome(np.zeros(5, np.int64), np.zeros(2)),
    )
    for first in range(0, len(times) - 1, PIECE):
        last = min(first + PIECE, len(times) - 1)
        system.run(
            integrate, system.evaluator(), system.plan, system.functions, curves, curves_x, levels, scheme, system.weights,
            options.tolerance, options.max_iterations, first, last, history, memory, outcome,
        )  # fmt: skip
        if outcome.counts[0] != CONVERGED:
            raise failure(system, outcome, times, options)
        if progress:
            progress(last, len(times) - 1)
    drift = check_drift(system, options, times, curves, history)
    return Solution.from_padded(
        system,
        times,
        history[:6],
        drift=drift,
        correction=float(outcome.correction[1]),
        options=options,
        own_start=q is not None or v is not None,
        newton_iterations=int(outcome.counts[4]),
        wall={"run": clock.perf_counter() - begun},
    )


def constraint_levels(options: RunOptions) -> np.ndarray:
    """Weights (1, 2 damping, stiffness^2) of acceleration, velocity and position in the constraint rows, (3,)."""
    step = time_grid(options)[1]
    damping, stiffness = options.baumgarte.damping, options.baumgarte.stiffness
    damping = 1 / step if damping is None else damping
    stiffness = np.sqrt(2) / step if stiffness is None else stiffness
    return np.array([1.0, 2 * damping, stiffness**2])


def allocate_history(system: System, n_t: int, start: tuple) -> History:
    """Memory for all states, the first filled in.

    Raises
    ------
    InputError
        The states need more memory than a machine has.
    """
    needed = 8 * n_t * sum(item.size for item in start)
    if needed > MOST_MEMORY:
        raise InputError(
            f"{n_t} states of {system.n} unknowns with {system.n_x} design variables need {needed / 1e9:.0f} GB, more than "
            f"{MOST_MEMORY / 1e9:.0f} GB. Choose a larger solver.step, a shorter time, or fewer design variables at once."
        )
    arrays = [np.zeros((n_t, *item.shape), system.dtype if item.ndim == 1 else float) for item in start]
    for array, item in zip(arrays, start, strict=True):
        array[0] = item
    return History(*arrays, *(array.reshape(n_t, -1) for array in arrays[3:]))


def check_drift(system: System, options: RunOptions, times: np.ndarray, curves: np.ndarray, history: History) -> float:
    """Largest violation of any joint, relative to the scene's size or in rad; refuse a run whose joints came apart.

    Raises
    ------
    ConvergenceError
        Names joint, time and remedy.
    """
    found = np.zeros(3)
    system.run(
        largest_drift, system.plan, system.functions, curves, system.weights, history.q, np.zeros(system.n, system.dtype), found,
        allocate_work(system.plan, system.dtype),
    )  # fmt: skip
    if not found[0] <= options.drift_tolerance:
        stabilised = constraint_levels(options)[2] > 0
        cause = f"the step of {times[1]:g} is far too large for this motion. Try a tenth of it" if stabilised else UNSTABILISED
        raise ConvergenceError(
            f"the joints came apart: {system.numbering.names[int(found[2])]} is off by {found[0]:.1e} of the scene's size at "
            f"t = {times[int(found[1])]:g}, more than solver.drift_tolerance = {options.drift_tolerance:g}: {cause}."
        )
    return float(found[0])


def failure(system: System, outcome: Outcome, times: np.ndarray, options: RunOptions) -> Exception:
    """The error that a failed step deserves."""
    status, step, iterations, worst, _ = (int(count) for count in outcome.counts)
    name, time = system.numbering.names[worst], times[step + 1]
    if status == SINGULAR:
        return SingularSystemError(
            f"the equations do not determine {name} at t = {time:g}: redundant joints, or a mechanism in a singular position. "
            "Remove the redundant joint, or start off the singular position."
        )
    what = f"correction {outcome.correction[0]:.1e} > {options.tolerance:.1e}" if status == NOT_CONVERGED else "not finite"
    return ConvergenceError(
        f"Newton stopped at t = {time:g} (step {step + 1} of {len(times) - 1}) after {iterations} iterations: {what}, "
        f"largest in {name}. Try a smaller solver.step (now {times[1]:g}) or a smoother load curve."
    )
