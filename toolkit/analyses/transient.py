"""Transient analysis: consistent start, the compiled step loop in pieces, and a check of what came out.

Steps that Newton cannot do, in halves: the run goes on from the state before them, and its times tell which steps it took.

Whatever repeats the run is given these times: derivatives are those of the steps that were taken, by every method.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from toolkit.analyses.run_start import accelerated_start, run_motion
from toolkit.description.run_options import LARGEST_RHO_CHANGING_STEPS, STEEPEST_STEP_CHANGE, RunOptions, step_lengths
from toolkit.foundation.errors import ConvergenceError, LimitPositionError, SingularSystemError, retold
from toolkit.foundation.processes import one_thread
from toolkit.solvers.half_turns import refuse_half_turns
from toolkit.solvers.start.initial_conditions import ConsistentMotion, State
from toolkit.solvers.static.passed_limits import refuse_passed_limits
from toolkit.solvers.transient.newton import CONVERGED, NOT_CONVERGED, NOT_FINITE, SINGULAR
from toolkit.solvers.transient.run import (
    STEPS_PER_CHOICE,
    Integration,
    advance_adaptively,
    allocate_history,
    at_limit_position,
    attempt,
    check_memory,
    failure,
    foreseen,
    prepare_run,
    take_steps,
)
from toolkit.solvers.transient.scheme import STEEPEST_GROWTH, relaxed
from toolkit.solvers.transient.step_memory import ALL_ITERATIONS, ITERATIONS, LARGEST, STATUS, STEP, History, Memory
from toolkit.system.solution import Solution
from toolkit.system.system import System
from toolkit.validity.bodies.critical_speed import fast_bodies
from toolkit.validity.bodies.physics import speed_limits
from toolkit.validity.components import told_frictions
from toolkit.validity.energy_balance import largest_drift
from toolkit.validity.judge import judge
from toolkit.validity.undisturbed import told_loads

UNSTABILISED = "nothing pulls them back. Leave out solver.baumgarte, or give it a positive stiffness"

JOINT_VIOLATION_OF_JUMP = 0.05
"""Violation of a joint, a part of the model size (or rad), that is no error of long steps: Newton has found another solution there."""


def can_be_closed(run: Integration) -> bool:
    """Whether joints that have come apart are a matter of the steps alone: positions are stabilised, and no joint was left out."""
    options = run.options
    return options.formulation == "index-1" and options.baumgarte.stiffness != 0 and len(run.system.plan.dropped) == 0


def drift(system: System, times: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Largest violation of any joint in states (n_t, n), and where it is, as `largest_drift` finds it."""
    found = np.zeros(4)
    system.run(
        largest_drift, system.plan, system.functions, system.curve_values(times), system.weights, q,
        np.zeros(system.n, system.dtype), found, system.work,
    )  # fmt: skip
    return found


def first_opened(run: Integration, q: np.ndarray, allowed: float) -> int | None:
    """First step to a state (n_t, n) in which joints are open by more than is allowed; None without any."""
    if not can_be_closed(run) or drift(run.system, run.times, q)[0] <= allowed:
        return None
    ends = (k for k in range(1, len(q)) if not drift(run.system, run.times[k : k + 1], q[k : k + 1])[0] <= allowed)
    return next(ends, 1) - 1


def check_drift(run: Integration, q: np.ndarray, first: int) -> float:
    """Largest violation of any joint in states (n, ...) from step `first` on, relative to the model size or in rad.

    Raises
    ------
    ConvergenceError
        The joints came apart, also those left out as redundant; names joint, time and remedy.
    """
    system, options, times = run.system, run.options, run.times[first : first + len(q)]
    found = drift(system, times, q)
    if not found[0] <= options.drift_tolerance and found[2] in system.plan.dropped:
        raise ConvergenceError(
            f"{system.numbering.names[int(found[2])]} was left out because other joints imply it at the start; it is off by {found[0]:.1e} "
            f"of the model size at t = {times[int(found[1])]:g}: they do so in the start position alone (a folded or stretched one), or "
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
            f"the joints came apart: {system.numbering.names[int(found[2])]} is off by {found[0]:.1e} of the model size at "
            f"t = {times[int(found[1])]:g}, more than solver.drift_tolerance = {options.drift_tolerance:g}: {cause}."
        )
        raise at_limit_position(run, q[0], float(times[0]), float(times[int(found[1])] - times[0]) / 10, came_apart)
    return float(found[0])


HALVED_STEPS, HALVED_PART, MOST_HALVINGS = 6, 0.15, 200
"""Steps of a run that may be halved, at most, or this part of all of them, and all halvings: of a run that needs more the steps are too
long everywhere. A pendulum that turns by half a turn in a step got through with six of ten steps halved, and nothing of it was right."""
LOCAL_ERROR_OF_JUMP = 0.05
"""Local error, a part of the model size (or rad), above which a halved step is halved again: Newton may have found another solution."""
STEPS_HALVED_BEFORE = 3
"""Steps before the one that fails which are halved, too, where its own halves do not help: what they have left may be why."""

States = tuple[np.ndarray, ...]
StepError = ConvergenceError | SingularSystemError


class Ahead(NamedTuple):
    """A time that is still to be reached, and how often the step to it has been halved."""

    time: float
    depth: int


def most_halvings(options: RunOptions) -> int:
    """Number of times that one step may be halved: as the options say, or as far as steps may change their length.

    Without inertia a step that fails tells of the end of a path of equilibria.
    """
    if (
        options.quasi_static
        or options.local_error is not None
        or (options.formulation == "index-3" and options.rho_inf > LARGEST_RHO_CHANGING_STEPS)
    ):
        return 0
    return options.halvings if options.formulation == "index-1" else min(options.halvings, int(np.log2(STEEPEST_STEP_CHANGE)))


def can_be_halved(run: Integration) -> bool:
    """Whether the step at which a run stopped may be tried in halves."""
    status, step, iterations = (int(run.outcome.counts[place]) for place in (STATUS, STEP, ITERATIONS))
    thrown_out = status == SINGULAR and (step > 0 or iterations > 1)
    forgotten = step > 0 and run.lengths[step] > STEEPEST_GROWTH * run.lengths[step - 1]  # see `step_ratio`
    return most_halvings(run.options) > 0 and (status in (NOT_CONVERGED, NOT_FINITE) or thrown_out) and not forgotten


def advance_in_halves(
    run: Integration, history: History, stopped: int, error: StepError, progress: Callable[[int, int], None] | None = None
) -> tuple[Integration, History, tuple[float, ...]]:
    """Go on at the step for which a run stopped with an error, in halves of those that fail or open the joints.

    Returns
    -------
    run, history, halved
        The run over the times that were needed, its states, and the times at which halved steps began.

    Raises
    ------
    ConvergenceError, SingularSystemError
        The error itself, and that halves of the step have failed, too.
    """
    thrown = first_thrown(run, history, stopped)
    try:
        return _in_halves(run, history, (thrown, min(thrown + STEPS_HALVED_BEFORE, stopped)), error, progress)
    except (ConvergenceError, SingularSystemError) as again:
        before = max(0, stopped - STEPS_HALVED_BEFORE)
        if isinstance(again, LimitPositionError) or before >= thrown:
            raise
        return _in_halves(run, history, (before, stopped), error, progress)


def _in_halves(
    run: Integration, history: History, steps: tuple[int, int], error: StepError, progress: Callable[[int, int], None] | None
) -> tuple[Integration, History, tuple[float, ...]]:
    """Result of `advance_in_halves` for a given range of steps, the first and last of those halved from the beginning."""
    (thrown, stopped), grid = steps, run.times
    stands = thrown == stopped and run.outcome.counts[STATUS] != CONVERGED  # the memory, where the run stopped
    kept = stopped if stands else 0  # elsewhere the run begins anew
    chunks: list[States] = [tuple(array[: kept + 1] for array in history[:6])]
    times, halvings = list(map(float, run.times[: kept + 1])), [Ahead(float(run.times[k]), 0) for k in range(thrown, stopped + 1)]
    ahead = [Ahead(float(time), 0) for time in run.times[: stopped + 1 : -1]]
    for k in range(stopped, thrown - 1, -1):
        ahead += _halves(float(run.times[k]), Ahead(float(run.times[k + 1]), 0))
    ahead += [Ahead(float(time), 0) for time in run.times[thrown:kept:-1]]
    run = run._replace(relaxation=run.relaxation[:kept], control=run.control._replace(foreseen=False))
    while ahead:
        way = _go_on(run, tuple(item[-1] for item in chunks[-1]), times[-1], ahead)
        if way.done:
            chunks.append(way.states)
            times += [ahead.pop().time for _ in range(way.done)]
            run = run._replace(relaxation=way.run.relaxation[: way.done])
        if way.failed:
            step = ahead.pop()
            too_many = _too_many(halvings, step, len(grid) - 1)
            if too_many or step.depth >= most_halvings(run.options):
                raise _not_helped(way, chunks[-1], error, too_many) from error
            halvings.append(Ahead(times[-1], step.depth))
            ahead += _halves(times[-1], step)
            check_memory(run.system, run.options, len(times) + len(ahead))
        if progress:
            progress(len(times) - 1, len(times) + len(ahead) - 1)
    return (*_joined(run, times, chunks), tuple(sorted(begin for begin, depth in halvings if depth == 0)))


def first_thrown(run: Integration, history: History, stopped: int) -> int:
    """First of the last `HALVED_STEPS` steps before one that were too long for their own errors, see `LOCAL_ERROR_OF_JUMP`; that
    one if none was."""
    first, weights, n_q = max(0, stopped - HALVED_STEPS), run.system.weights, run.system.n_q
    changes = weights[:n_q] * np.abs(np.diff(np.real(history.acc[first : stopped + 1, :n_q]), axis=0))
    errors = abs(run.scheme.error) * run.lengths[first:stopped] ** 2 * np.max(changes, axis=1, initial=0.0)
    return first + int(np.argmax(errors > LOCAL_ERROR_OF_JUMP)) if np.any(errors > LOCAL_ERROR_OF_JUMP) else stopped


def _halves(begin: float, step: Ahead) -> list[Ahead]:
    """Halves of a step, the later one first."""
    return [Ahead(step.time, step.depth + 1), Ahead((begin + step.time) / 2, step.depth + 1)]


def _too_many(halvings: list[Ahead], step: Ahead, steps: int) -> bool:
    """Whether too many steps of a run were halved for another one."""
    begun = sum(each.depth == 0 for each in [*halvings, step])
    return begun > max(HALVED_STEPS, HALVED_PART * steps) or len(halvings) >= MOST_HALVINGS


class Way(NamedTuple):
    """Some steps towards the next times, with the states and the run that they led to."""

    done: int
    states: States  # that were reached
    run: Integration  # that the steps are of

    @property
    def failed(self) -> bool:
        """Whether there is a step that was not done."""
        return self.done < len(self.run.lengths)


def _go_on(run: Integration, state: States, time: float, ahead: list[Ahead]) -> Way:
    """Next step to take, or the next ones that are equally long and were never halved."""
    count = 1
    if ahead[-1].depth == 0:
        lengths = step_lengths(np.array([time, *(each.time for each in ahead[: -STEPS_PER_CHOICE - 1 : -1])]))
        count = len(lengths) if np.all(lengths == lengths[0]) else 1
    times = np.array([time, *(each.time for each in ahead[: -count - 1 : -1])])
    memory = run.memory
    inherited = memory.aux, memory.daux, memory.span, memory.carried, memory.dcarried
    kept = [array.copy() for array in inherited]
    limited = 0 < ahead[-1].depth < most_halvings(run.options)
    run = run._replace(control=run.control._replace(largest_error=LOCAL_ERROR_OF_JUMP if limited else np.inf))
    done, piece, states = attempt(run, state, times, step_lengths(times))
    closed = _closed(run, times[1 : done + 1], states[0])
    if closed < done or done == 0:  # the step that failed has scaled some of it to its own length
        for array, before in zip(inherited, kept, strict=True):
            array[:] = before
    if 0 < closed < done:
        states = attempt(run, state, times[: closed + 1], piece.lengths[:closed])[2]
    return Way(closed, states, piece)


def _closed(run: Integration, times: np.ndarray, q: np.ndarray) -> int:
    """Number of these states with closed joints, up to the first whose joints are open."""
    allowed = run.options.drift_tolerance
    if not can_be_closed(run) or drift(run.system, times, q)[0] <= allowed:
        return len(q)
    return next(k for k in range(len(q)) if not drift(run.system, times[k : k + 1], q[k : k + 1])[0] <= allowed)


def _not_helped(way: Way, last: States, error: StepError, everywhere: bool) -> Exception:
    """Error of the step at which a run stopped, where halving did not help.

    Halves of it have failed behind a `last` state, or too many of its steps.
    """
    time, step = float(way.run.times[way.done]), float(way.run.lengths[0])
    lasting = f"Halved down to {step:.2g} it fails, too, at t = {time:.4g}: the scene may ask for what cannot be done there (a mechanism "
    lasting += "that locks), or something jumps or is far stiffer than all else (a spring, a friction, a curve)."
    many = f"Halves of its first steps do not help: up to t = {time:.4g} so many fail that all are too long."
    told = at_limit_position(way.run, last[0][-1], time, step, retold(error, f"{error} {many if everywhere else lasting}"))
    if isinstance(told, ConvergenceError):
        told.state = time, last[0][-1], last[1][-1]
    return told


def _joined(run: Integration, times: list[float], chunks: list[States]) -> tuple[Integration, History]:
    """All pieces of a run, joined to one run with its times and states."""
    states = [np.concatenate(parts) for parts in zip(*chunks, strict=True)]
    found = np.array(times)
    lengths = step_lengths(found)
    run = run._replace(times=found, lengths=lengths, relaxation=relaxed(lengths))
    return run, History(*states, *(array.reshape(len(found), -1) for array in states[3:]))


STEPS_PER_REPORT, UNKNOWNS_PER_REPORT = 200, 1_000_000
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
    known: ConsistentMotion | State | None = None,
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
    found.known[ConsistentMotion] = motion
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
    if (step := first_opened(run, history.q, JOINT_VIOLATION_OF_JUMP)) is not None:
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
    piece = max(STEPS_PER_REPORT, UNKNOWNS_PER_REPORT // run.system.n)
    for low in range(0, count, piece):
        high = min(low + piece, count)
        take_steps(run, history, curves, first + low == 0, low, high)
        if run.outcome.counts[STATUS] != CONVERGED:
            before = run.outcome.counts[STEP]
            raise failure(run, history.q[before], history.v[before])
        if progress:
            progress(first + high, total)
