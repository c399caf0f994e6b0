"""Transient analysis: consistent start, the compiled step loop in pieces, and a check of what came out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from toolkit.analyses.halved_steps import StepError, advance_in_halves, can_be_halved, first_thrown, most_halvings
from toolkit.analyses.joint_drift import THROWN_OPEN, check_drift, first_opened
from toolkit.analyses.run_start import accelerated_start, run_motion
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError, LimitPositionError, SingularSystemError
from toolkit.foundation.processes.one_thread import one_thread
from toolkit.solvers.half_turns import refuse_half_turns
from toolkit.solvers.start.initial_conditions import Motion, State
from toolkit.solvers.static.passed_limits import refuse_passed_limits
from toolkit.solvers.transient.adaptive import advance_adaptively
from toolkit.solvers.transient.newton import CONVERGED
from toolkit.solvers.transient.run import Integration, allocate_history, failure, foreseen, prepare_run, take_steps
from toolkit.solvers.transient.step_memory import ALL_ITERATIONS, LARGEST, STATUS, STEP, History, Memory
from toolkit.system.solution import Solution
from toolkit.system.system import System
from toolkit.validity.bodies.physics import speed_limits
from toolkit.validity.bodies.spinning.critical_speed import fast_bodies
from toolkit.validity.judge import judge
from toolkit.validity.motion.creeping_friction import told_frictions
from toolkit.validity.start.sudden_loads import told_loads

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
    known: Motion | State | None = None,
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
    known : Motion or State
        The start of the same motion with other steps (`run_start.known_start`), which is not sought again.

    Raises
    ------
    InputError, SingularSystemError
        As `consistent_start`; or the step does not fit into the time.
    ConvergenceError
        Newton failed, the joints drifted apart, or a spring in space turned too far: names time, equation and remedy.
    """
    run = prepare_run(system, options)
    motion = run_motion(system, run.options, q, v, beside) if known is None else known
    start, halved = accelerated_start(system, run.options, motion), tuple[float, ...]()
    with _causes_told(run):
        if run.options.local_error is not None:
            run, history = advance_adaptively(run, start, progress)
        else:
            history = allocate_history(system, run.options, len(run.times), start)
            run = foreseen(run, history, along) if along else run
            try:
                advance(run, history, 0, progress)
            except (ConvergenceError, SingularSystemError) as error:
                run, history, halved = _halved(run, history, error, progress)
    if run.options.quasi_static:
        history.acc[:, : system.n_q] = 0  # the loop's unknowns there are no accelerations
        history.dacc[:, : system.n_q] = 0
        if system.compiled:  # a complex step takes the steps of its real design, which have been checked
            refuse_passed_limits(system, run.options, run.times, history.q, history.acc)
    refuse_half_turns(system, run.times, history.q)
    run, history, halved, drift = _with_closed_joints(run, history, halved, progress)
    system.give_back(Memory, run.memory)
    found = Solution.from_padded(
        system,
        run.times,
        history[:6],
        drift=drift,
        correction=float(run.outcome.correction[LARGEST]),
        local_error=run.largest_local_error,
        options=run.options,
        own_start=q is not None or v is not None,
        newton_iterations=int(run.outcome.counts[ALL_ITERATIONS]),
        halved=halved,
        judge=judge,
    )
    found.known[Motion] = motion
    return found


@contextmanager
def _causes_told(run: Integration) -> Iterator[None]:
    """Block in which an error of convergence is told with its further causes."""
    try:
        yield
    except LimitPositionError:
        raise
    except ConvergenceError as error:
        raise ConvergenceError(" ".join(filter(None, [str(error), *_causes(run, error)]))) from error


def _causes(run: Integration, error: ConvergenceError) -> Iterator[str]:
    """Further causes of a failed run: frames that spin fast by then, or loads that act at once where it begins."""
    if error.state is None:
        return
    time, q, v = error.state
    none = np.zeros((1, run.system.n, 0))
    last = Solution.from_padded(run.system, np.array([time]), (q[None], v[None], np.zeros((1, run.system.n)), none, none, none))
    yield speed_limits(run.system.scene, fast_bodies(last))
    yield told_frictions(run.system, q, run.options.step)
    if time < run.options.step:
        yield told_loads(run.system.scene, run.options)


def _halved(
    run: Integration, history: History, error: StepError, progress: Callable[[int, int], None] | None
) -> tuple[Integration, History, tuple[float, ...]]:
    """The integration with halves of the steps that failed, all its states, and the times at which these began."""
    if isinstance(error, LimitPositionError) or not can_be_halved(run):
        raise error
    return advance_in_halves(run, history, int(run.outcome.counts[STEP]), error, progress)


def _thrown_open(run: Integration, history: History) -> int | None:
    """First step that has thrown the joints open; None without any.

    Also a step counts that has opened the joints and followed upon one that was thrown out itself.
    """
    if (step := first_opened(run, history.q, THROWN_OPEN)) is not None:
        return step
    step = first_opened(run, history.q, run.options.drift_tolerance)
    return None if step is None or first_thrown(run, history, step + 1) > step else step


def _with_closed_joints(
    run: Integration, history: History, halved: tuple[float, ...], progress: Callable[[int, int], None] | None
) -> tuple[Integration, History, tuple[float, ...], float]:
    """The run, or the run with halves of steps that threw its joints open, and the largest gap of its joints."""
    try:
        return run, history, halved, check_drift(run, history.q, 0)
    except ConvergenceError as error:
        step = None if halved or most_halvings(run.options) == 0 else _thrown_open(run, history)
        if isinstance(error, LimitPositionError) or step is None:
            raise
        run, history, halved = advance_in_halves(run, history, step, error, progress)
    return run, history, halved, check_drift(run, history.q, 0)


def advance(run: Integration, history: History, first: int, progress: Callable[[int, int], None] | None = None) -> None:
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
            before = run.outcome.counts[STEP]
            raise failure(run, history.q[before], history.v[before])
        if progress:
            progress(first + high, total)
