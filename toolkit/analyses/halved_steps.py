"""Steps that Newton cannot do, in halves: the run goes on from the state before them, and its times tell which steps it took.

Whatever repeats the run is given these times: derivatives are those of the steps that were taken, by every method.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from toolkit.analyses.joint_drift import can_be_closed, drift
from toolkit.description.option_checks import DAMPED_CHANGING, STEEPEST
from toolkit.description.run_options import RunOptions
from toolkit.description.time_grid import step_lengths
from toolkit.foundation.errors import ConvergenceError, LimitPositionError, SingularSystemError, retold
from toolkit.solvers.transient.adaptive import MOST, attempt
from toolkit.solvers.transient.formulation import relaxed
from toolkit.solvers.transient.newton import CONVERGED, NOT_CONVERGED, NOT_FINITE, SINGULAR
from toolkit.solvers.transient.prediction import STEEP
from toolkit.solvers.transient.run import Integration, at_limit_position, check_memory
from toolkit.solvers.transient.step_memory import ITERATIONS, STATUS, STEP, History

FEW, PART, MOST_IN_ALL = 6, 0.15, 200
"""Steps of a run that may be halved, at most, or this part of all of them, and all halvings: of a run that needs more the steps are too
long everywhere. A pendulum that turns by half a turn in a step got through with six of ten steps halved, and nothing of it was right."""
THROWN = 0.05
"""Local error, a part of the model size (or rad), above which a halved step is halved again: Newton may have found another solution."""
BEFORE = 3
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
        or (options.formulation == "index-3" and options.rho_inf > DAMPED_CHANGING)
    ):
        return 0
    return options.halvings if options.formulation == "index-1" else min(options.halvings, int(np.log2(STEEPEST)))


def can_be_halved(run: Integration) -> bool:
    """Whether the step at which a run stopped may be tried in halves."""
    status, step, iterations = (int(run.outcome.counts[place]) for place in (STATUS, STEP, ITERATIONS))
    thrown_out = status == SINGULAR and (step > 0 or iterations > 1)
    forgotten = step > 0 and run.lengths[step] > STEEP * run.lengths[step - 1]  # see `step_ratio`
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
        return _in_halves(run, history, (thrown, min(thrown + BEFORE, stopped)), error, progress)
    except (ConvergenceError, SingularSystemError) as again:
        before = max(0, stopped - BEFORE)
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
    """First of the last `FEW` steps before one that were too long for their own errors, see `THROWN`; that one if none was."""
    first, weights, n_q = max(0, stopped - FEW), run.system.weights, run.system.n_q
    changes = weights[:n_q] * np.abs(np.diff(np.real(history.acc[first : stopped + 1, :n_q]), axis=0))
    errors = abs(run.scheme.error) * run.lengths[first:stopped] ** 2 * np.max(changes, axis=1, initial=0.0)
    return first + int(np.argmax(errors > THROWN)) if np.any(errors > THROWN) else stopped


def _halves(begin: float, step: Ahead) -> list[Ahead]:
    """Halves of a step, the later one first."""
    return [Ahead(step.time, step.depth + 1), Ahead((begin + step.time) / 2, step.depth + 1)]


def _too_many(halvings: list[Ahead], step: Ahead, steps: int) -> bool:
    """Whether too many steps of a run were halved for another one."""
    begun = sum(each.depth == 0 for each in [*halvings, step])
    return begun > max(FEW, PART * steps) or len(halvings) >= MOST_IN_ALL


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
        lengths = step_lengths(np.array([time, *(each.time for each in ahead[: -MOST - 1 : -1])]))
        count = len(lengths) if np.all(lengths == lengths[0]) else 1
    times = np.array([time, *(each.time for each in ahead[: -count - 1 : -1])])
    memory = run.memory
    inherited = memory.aux, memory.daux, memory.span, memory.carried, memory.dcarried
    kept = [array.copy() for array in inherited]
    limited = 0 < ahead[-1].depth < most_halvings(run.options)
    run = run._replace(control=run.control._replace(largest_error=THROWN if limited else np.inf))
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
