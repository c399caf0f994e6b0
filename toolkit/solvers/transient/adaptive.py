"""Steps chosen as the run goes, so that each makes at most the local error that was asked for.

The compiled loop takes steps of one length and stops where one is rejected or the next may be longer; here the length is chosen,

    h_new = SAFETY h (allowed / estimated)^(1/k),    k = 3 (2 without inertia), the order of the local error

and where the run has to stop: at corners of load curves, where the motion is less smooth than the error estimate supposes, and at times
that responses look at.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.solvers.start.initial_conditions import State
from toolkit.solvers.transient.formulation import relaxed
from toolkit.solvers.transient.newton import CONVERGED, EASY, REJECTED
from toolkit.solvers.transient.run import Integration, check_memory, empty_history, failure, take_steps
from toolkit.solvers.transient.step_memory import LAST_ERROR, LATE_ERROR, STATUS, STEP, History
from toolkit.system.system import System

SAFETY, SHRINK, RETRY, GROW, MOST = 0.8, 0.1, 0.25, 4.0, 50
"""Part of the length that the estimate allows; least and, where Newton failed, usual part of a rejected length; largest growth; most steps
before the length is looked at again."""
WORTH = 1.5
"""Growth for which the loop is stopped: Jacobians that were kept would have to be made anew."""
GRADE = 10.0
"""Towards two stops that lie close together steps shrink by at most this: a joint's velocity error is a blow to a much shorter step."""
SMALLEST = 1e-9
"""Part of the run below which a step is not shortened any more."""


def advance_adaptively(
    run: Integration, start: State, progress: Callable[[int, int], None] | None
) -> tuple[Integration, History]:
    """States of the whole run from a start, and the run over the times that were chosen.

    Raises
    ------
    ConvergenceError, SingularSystemError, InputError
        As `simulate`; or even the shortest step makes too large an error.
    """
    options, order = run.options, 2 if run.options.quasi_static else 3
    allowed = float(options.local_error or np.inf)
    run = run._replace(control=run.control._replace(largest_error=allowed, easy_error=allowed * (SAFETY / WORTH) ** order))
    chunks: list[tuple[np.ndarray, ...]] = [empty_history(run.system, 1, start)[:6]]
    times, h, places = [0.0], min(options.step, options.end_time), stops(run.system, options)
    for stop, after in pairwise([*places, np.inf]):
        while times[-1] < stop:
            most = max(GRADE * (after - stop), (1 - 1 / GRADE) * (stop - times[-1]))
            done, piece, chunk = _attempt(run, tuple(item[-1] for item in chunks[-1]), times[-1], stop, min(h, most))
            status, length = run.outcome.counts[STATUS], piece.lengths[0]
            if done:
                chunks.append(chunk)
                times += piece.times[1 : done + 1].tolist()
                run = run._replace(relaxation=piece.relaxation[done - 1 : done])
                check_memory(run.system, options, len(times))
            if status in (REJECTED, EASY):
                made = run.outcome.correction[LAST_ERROR if status == REJECTED else LATE_ERROR]
                ratio = SAFETY * (allowed / max(made, allowed / GROW**4)) ** (1 / order)
                found = length * np.clip(ratio, SHRINK, GROW)
                h = min(options.step, max(h, found) if status == EASY else found)  # a step to a stop may be shorter than need be
            elif status != CONVERGED:
                h = RETRY * length
            if h < SMALLEST * options.end_time:
                raise failure(piece, chunks[-1][0][-1], chunks[-1][1][-1])
            if progress:
                progress(round(1000 * times[-1] / options.end_time), 1000)
    states = [np.concatenate(parts) for parts in zip(*chunks, strict=True)]
    found = np.array(times)
    run = run._replace(times=found, lengths=np.diff(found), relaxation=relaxed(np.diff(found)))
    return run, History(*states, *(array.reshape(len(found), -1) for array in states[3:]))


def _attempt(
    run: Integration, state: tuple, time: float, stop: float, h: float
) -> tuple[int, Integration, tuple[np.ndarray, ...]]:
    """Result of steps of about the length h towards a stop, as that of `attempt`."""
    needed = max(1, int(np.ceil((stop - time) / h * (1 - SMALLEST))))
    count = min(needed, MOST)
    length = (stop - time) / needed if needed <= MOST else h
    times = time + length * np.arange(count + 1)
    if needed == count:
        times[-1] = stop
    if length >= run.options.step * (1 - SMALLEST):
        run = run._replace(control=run.control._replace(easy_error=0.0))
    return attempt(run, state, times, np.full(count, length))


def attempt(
    run: Integration, state: tuple, times: np.ndarray, lengths: np.ndarray
) -> tuple[int, Integration, tuple[np.ndarray, ...]]:
    """Result of steps through times (n_t,): how many were accepted, the run that they are of, and their states.

    The state at the first time is given.
    """
    before = float(run.relaxation[-1]) if times[0] > 0 else 0.0
    piece = run._replace(times=times, lengths=lengths, relaxation=relaxed(lengths, before))
    history = empty_history(run.system, len(times), state)
    take_steps(piece, history, run.system.curves(times), times[0] == 0, 0, len(lengths))
    status, last = run.outcome.counts[STATUS], run.outcome.counts[STEP]
    done = len(lengths) if status == CONVERGED else int(last) + int(status == EASY)
    return done, piece, tuple(array[1 : done + 1] for array in history[:6])


def stops(system: System, options: RunOptions) -> list[float]:
    """Times that the run has to hit, the end last: corners of curves, and times that responses look at."""
    corners = [time for curve in system.values.curves.values() for time in curve.corners()]
    asked = [getattr(response, "time", None) or 0.0 for response in system.scene.responses.values()]
    end, shortest = options.end_time, SMALLEST * options.end_time
    inside = sorted({float(np.real(time)) for time in [*corners, *asked] if 0 < np.real(time) < end - shortest})
    return [*(time for before, time in pairwise([0.0, *inside]) if time - before > shortest), end]
