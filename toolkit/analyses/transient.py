"""Transient analysis: consistent start, the compiled step loop in pieces, and a check of what came out."""

from __future__ import annotations

import time as clock
from collections.abc import Callable

import numpy as np

from toolkit.analyses.run_start import run_start
from toolkit.description.run_options import RunOptions
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.foundation.errors import ConvergenceError, LimitPositionError
from toolkit.foundation.processes.one_thread import one_thread
from toolkit.solvers.half_turns import refuse_half_turns
from toolkit.solvers.start.initial_conditions import State
from toolkit.solvers.static.passed_limits import refuse_passed_limits
from toolkit.solvers.transient.adaptive import advance_adaptively
from toolkit.solvers.transient.newton import CONVERGED
from toolkit.solvers.transient.run import Run, allocate_history, at_limit_position, failure, foreseen, prepare_run, take_steps
from toolkit.solvers.transient.step_memory import ALL_ITERATIONS, LARGEST, STATUS, STEP, History, Memory
from toolkit.system.solution import Solution
from toolkit.system.system import System
from toolkit.validity.bodies.physics import speed_limits
from toolkit.validity.judge import judge
from toolkit.validity.motion.drift import largest_drift

UNSTABILISED = "nothing pulls them back. Leave out solver.baumgarte, or give it a positive stiffness"
PIECE, MANY = 200, 1_000_000
"""Least number of steps between two reports of progress, and of unknowns at all of them: some tenths of a second, beside which a report
costs nothing, and that all memory is handed over anew for the next steps."""


@one_thread()
def simulate(
    system: System,
    options: RunOptions | None = None,
    q: np.ndarray | None = None,
    v: np.ndarray | None = None,
    progress: Callable[[int, int], None] | None = None,
    beside: Solution | None = None,
    along: Solution | None = None,
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
    beside : Solution
        Of `start_at_rest`, for the scene whose numbers differ by nothing but a complex step: the equilibrium is found from there.
    along : Solution
        The motion of such a scene through the same times: Newton begins at its states, which saves a third of the iterations.

    Raises
    ------
    InputError, SingularSystemError
        As `consistent_start`; or the step does not fit into the time.
    ConvergenceError
        Newton failed, the joints drifted apart, or a spring in space turned too far: names time, equation and remedy.
    """
    begun = clock.perf_counter()
    with watched_compilation() as compiled:
        run = prepare_run(system, options)
        start = run_start(system, run.options, q, v, beside)
        try:
            run, history = _integrated(run, start, progress, along)
        except LimitPositionError:
            raise
        except ConvergenceError as error:
            hint = speed_limits(system.scene)
            if not hint:
                raise
            raise ConvergenceError(f"{error} {hint}") from error
    if run.options.quasi_static:
        history.acc[:, : system.n_q] = 0  # the loop's unknowns there are no accelerations
        history.dacc[:, : system.n_q] = 0
        if system.compiled:  # a complex step takes the steps of its real design, which have been checked
            refuse_passed_limits(system, run.options, run.times, history.q, history.acc)
    refuse_half_turns(system, run.times, history.q)
    system.give_back(Memory, run.memory)
    return Solution.from_padded(
        system,
        run.times,
        history[:6],
        drift=check_drift(run, history.q, 0),
        correction=float(run.outcome.correction[LARGEST]),
        local_error=run.largest_local_error,
        options=run.options,
        own_start=q is not None or v is not None,
        newton_iterations=int(run.outcome.counts[ALL_ITERATIONS]),
        wall={"run": clock.perf_counter() - begun - compiled.seconds},
        judge=judge,
    )


def _integrated(
    run: Run, start: State, progress: Callable[[int, int], None] | None, along: Solution | None
) -> tuple[Run, History]:
    """The run, over the times that it chose if it chooses them, and all its states."""
    if run.options.local_error is not None:
        return advance_adaptively(run, start, progress)
    history = allocate_history(run.system, run.options, len(run.times), start)
    run = foreseen(run, history, along) if along else run
    advance(run, history, 0, progress)
    return run, history


def advance(run: Run, history: History, first: int, progress: Callable[[int, int], None] | None = None) -> None:
    """Fill a history whose row 0 is the state at step `first`, where `run.memory` stands.

    Raises
    ------
    ConvergenceError, SingularSystemError
        As `simulate`.
    """
    total = len(run.times) - 1
    count = len(history.q) - 1
    part = slice(first, first + count)
    run = run._replace(times=run.times[first : first + count + 1], lengths=run.lengths[part], relaxation=run.relaxation[part])
    curves = run.system.curves(run.times)
    piece = max(PIECE, MANY // run.system.n)
    for low in range(0, count, piece):
        high = min(low + piece, count)
        take_steps(run, history, curves, first + low == 0, low, high)
        if run.outcome.counts[STATUS] != CONVERGED:
            raise failure(run, history.q[run.outcome.counts[STEP]])
        if progress:
            progress(first + high, total)


def check_drift(run: Run, q: np.ndarray, first: int) -> float:
    """Largest violation of any joint in states (n, ...) from step `first` on, relative to the scene's size or in rad.

    Raises
    ------
    ConvergenceError
        The joints came apart, also those left out as redundant; names joint, time and remedy.
    """
    system, options, times = run.system, run.options, run.times[first : first + len(q)]
    found, curves = np.zeros(4), system.curve_values(times)
    system.run(
        largest_drift, system.plan, system.functions, curves, system.weights, q, np.zeros(system.n, system.dtype), found,
        system.work,
    )  # fmt: skip
    if not found[0] <= options.drift_tolerance and found[2] in system.plan.dropped:
        raise ConvergenceError(
            f"{system.numbering.names[int(found[2])]} was left out because other joints imply it at the start; it is off by {found[0]:.1e} "
            f"of the scene's size at t = {times[int(found[1])]:g}: they do so in the start position alone (a folded or stretched one), or "
            "points and axes do not fit exactly. Start elsewhere, fix them, or remove the joint that is too much."
        )
    if not found[0] <= options.drift_tolerance:
        stabilised = options.baumgarte.stiffness != 0
        cause = (
            f"the step of {run.lengths.max():g} is far too large for this motion. Try a tenth of it"
            if stabilised
            else UNSTABILISED
        )
        came_apart = ConvergenceError(
            f"the joints came apart: {system.numbering.names[int(found[2])]} is off by {found[0]:.1e} of the scene's size at "
            f"t = {times[int(found[1])]:g}, more than solver.drift_tolerance = {options.drift_tolerance:g}: {cause}."
        )
        raise at_limit_position(run, q[0], float(times[0]), float(times[int(found[1])] - times[0]) / 10, came_apart)
    return float(found[0])
