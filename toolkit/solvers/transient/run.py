"""An integration over time: what its steps share, the compiled loop over them, memory for their states, and what a failed one deserves.

Steps chosen as the run goes, so that each makes at most the local error that was asked for.

The compiled loop takes steps of one length and stops where one is rejected or the next may be longer; here the length is chosen,

    h_new = STEP_SAFETY h (allowed / estimated)^(1/k),    k = 3 (2 without inertia), the order of the local error

and where the run has to stop: at corners of load curves, where the motion is less smooth than the error estimate supposes, and at times
that responses look at.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from toolkit.description.run_options import RunOptions, step_lengths, time_grid
from toolkit.foundation.errors import ConvergenceError, InputError, LimitPositionError, SingularSystemError
from toolkit.foundation.memory_sizes import GIGABYTE, in_gigabytes, zeros_in_large_pages
from toolkit.solvers.start.initial_conditions import State
from toolkit.solvers.start.open_joints import limit_of_drivers, told_limit
from toolkit.solvers.transient.generalized_alpha import integrate
from toolkit.solvers.transient.ggl_step import allocate_ggl, idle_ggl
from toolkit.solvers.transient.newton import CONVERGED, EASY, JUMPED, NOT_CONVERGED, REJECTED, SINGULAR, Control
from toolkit.solvers.transient.scheme import Scheme, constraint_levels, relaxed, scheme_of
from toolkit.solvers.transient.step_memory import (
    LARGEST_ERROR,
    LAST,
    LAST_ERROR,
    LATE_ERROR,
    STATUS,
    STEP,
    History,
    LoopReport,
    Memory,
    taken_memory,
)
from toolkit.system.solution import Solution
from toolkit.system.system import System

REUSED_FACTORS_MOVE, REUSED_FACTORS_FORCE = 100.0, 1e-3
"""Moves, in parts of the tolerance, that kept factors of modified Newton may cause over a whole run, and in one equilibrium
without inertia."""


class Integration(NamedTuple):
    """Everything that all steps of a run share, and the memory of what one leaves to the next."""

    system: System
    options: RunOptions
    times: np.ndarray
    lengths: np.ndarray  # (n_t - 1,)
    relaxation: np.ndarray  # (n_t - 1,) see `relaxed`
    scheme: Scheme
    control: Control
    memory: Memory
    ggl: Any  # `Ggl`; idle in other formulations
    outcome: LoopReport

    @property
    def largest_local_error(self) -> float | None:
        """Largest local error of all steps so far, in parts of the model size; None where it is not estimated for the motion."""
        estimated = not self.options.quasi_static and self.options.scheme != "paper"  # whose accelerations lag behind
        return float(self.outcome.correction[LARGEST_ERROR]) if estimated else None


def prepare_run(system: System, options: RunOptions | None = None) -> Integration:
    """Integration with everything but the states; options by default the scene's own."""
    options = options or system.scene.solver
    times = time_grid(options)
    lengths = step_lengths(times)
    modified = options.newton == "modified" and system.compiled  # a complex step is the judge, by exact Jacobians
    control = Control(
        options.tolerance, options.max_iterations, modified, not system.compiled, left_by_kept(options), np.inf, 0.0, False
    )
    closed_twice = options.formulation == "ggl"
    memory = taken_memory(system, not closed_twice)
    ggl = allocate_ggl(system.plan, system.weights, system.dtype) if closed_twice else idle_ggl(system.dtype)
    outcome = LoopReport(np.zeros(5, np.int64), np.zeros(6))
    return Integration(system, options, times, lengths, relaxed(lengths), scheme_of(options), control, memory, ggl, outcome)


def left_by_kept(options: RunOptions) -> float:
    """`Control.left` of a run, in parts of the model size over time^2; without inertia in parts of the model size."""
    if options.quasi_static:
        return REUSED_FACTORS_FORCE * options.tolerance
    return REUSED_FACTORS_MOVE * options.tolerance / options.end_time**2


def take_steps(
    run: Integration, history: History, curves: tuple[np.ndarray, np.ndarray], begins: bool, first: int, last: int
) -> None:
    """Take steps first ... last - 1 of a run, whose state 0 is the consistent start if it `begins`.

    The outcome tells how far they came.
    """
    system, levels = run.system, constraint_levels(run.options, run.lengths, run.relaxation)
    system.run(
        integrate, system.evaluator, system.plan, system.functions, *curves, run.lengths, levels, run.scheme, system.weights,
        run.control, begins, first, last, history, run.memory, run.ggl, run.outcome,
    )  # fmt: skip


def foreseen(run: Integration, history: History, along: Solution) -> Integration:
    """Integration whose Newton begins at the states of a motion through the same times.

    Without inertia it keeps no unknowns of the loop.
    """
    if run.options.quasi_static or not np.array_equal(along.times, run.times):
        return run
    history.acc[1:] = np.hstack([along.a[1:], along.multipliers[1:]])
    return run._replace(control=run.control._replace(foreseen=True))


def allocate_history(system: System, options: RunOptions, n_t: int, start: tuple) -> History:
    """Memory for all states, the first filled in.

    Raises
    ------
    InputError
        The states need more memory than `solver.memory`.
    """
    check_memory(system, options, n_t)
    return empty_history(system, n_t, start)


def check_memory(system: System, options: RunOptions, n_t: int) -> None:
    """Refuse more states than fit into memory, as `allocate_history`."""
    needed = 8 * n_t * (3 * system.n + system.n_x * (2 * system.n_q + system.n))
    if needed > GIGABYTE * options.memory:
        coarser = "solver.step" if options.local_error is None else "solver.local_error"
        raise InputError(
            f"{n_t} states of {system.n} unknowns with {system.n_x} design variables need {in_gigabytes(needed)}, more than "
            f"solver.memory = {options.memory:g} GB. Choose a larger {coarser}, a shorter time, or fewer design variables at once; "
            "or the adjoint method, which keeps checkpoints only, unless steps are chosen."
        )


def empty_history(system: System, n_t: int, start: tuple) -> History:
    """Memory for n_t states, the first filled in."""
    arrays: list[np.ndarray] = [np.zeros((n_t, *item.shape), system.dtype) for item in start[:3]]
    n_x, rows = start[3].shape[1], (system.n_q, system.n_q, system.n)
    memory = zeros_in_large_pages(n_t * n_x * sum(rows))  # together, so that they have few pages
    parts = np.split(memory, n_t * n_x * np.cumsum(rows)[:2])
    arrays += [part.reshape(n_t, count, n_x) for part, count in zip(parts, rows, strict=True)]
    for array, item in zip(arrays, start, strict=True):
        array[0] = item[: array.shape[1]]
    return History(*arrays, *(array.reshape(n_t, -1) for array in arrays[3:]))


LEVELS = np.array([0.0, 0.0, 1.0])
LIMIT_DISTANCE = 0.05
"""Part of the run, or ten steps, within which a limit position behind a failed step is its cause."""


def failure(run: Integration, q: np.ndarray, v: np.ndarray) -> Exception:
    """Error that a failed step deserves, from the coordinates and velocities (n,) before it."""
    step = int(run.outcome.counts[STEP])
    error = at_limit_position(run, q, float(run.times[step]), float(run.lengths[step]), failure_of_step(run))
    if isinstance(error, ConvergenceError):
        error.state = float(run.times[step]), q, v
    return error


def at_limit_position(run: Integration, q: np.ndarray, time: float, step_length: float, error: Exception) -> Exception:
    """Error of a run at a time, or one that tells of the mechanism's limit position, if drivers lead to it right then."""
    system, end = run.system, run.options.end_time
    limit = limit_of_drivers(system, lambda at: system.inputs(at, LEVELS), q, (0.0, time, end))
    if limit is None or limit.place > time + max(LIMIT_DISTANCE * end, 10 * step_length):
        return error
    where = f"at t = {limit.place:.4g}"
    return LimitPositionError(told_limit(system, lambda at: system.inputs(at, LEVELS), limit, end, where))


def failure_of_step(run: Integration) -> Exception:
    """Error that a failed step deserves by what the step itself tells."""
    status, step, iterations, worst, _ = (int(count) for count in run.outcome.counts)
    name, time, tolerance = run.system.numbering.names[worst], run.times[step + 1], run.options.tolerance
    step_length = run.lengths[step]
    if status == REJECTED:
        return ConvergenceError(
            f"no step at t = {run.times[step]:g} is short enough: one of {step_length:.1e} makes a local error of "
            f"{run.outcome.correction[LAST_ERROR]:.1e} > solver.local_error = {run.options.local_error:.1e}. Something jumps there, or the "
            "error asked for is below round-off: choose a larger one, or smoother loads."
        )
    if status == JUMPED:
        return ConvergenceError(
            f"the quasi-static motion jumps at t = {time:g}: the next equilibrium is far from where the last two point to. Past a limit "
            "point (snap-through) there is none nearby, and only a run with inertia can follow; otherwise the step of "
            f"{step_length:g} is too large. Try a smaller solver.step, or solver.local_error."
        )
    if status == SINGULAR and (step > 0 or iterations > 1):  # the start itself was left behind
        return SingularSystemError(
            f"the equations do not determine {name} at t = {time:g}: a mechanism in a singular position, or one that a step of "
            f"{step_length:g} has thrown out of place. Try a tenth of solver.step; if it ends at the same time again, the position is "
            "singular."
        )
    if status == SINGULAR:
        return SingularSystemError(
            f"the equations do not determine {name} at t = {time:g}: redundant joints, or a mechanism in a singular position. "
            "Remove the redundant joint, or start off the singular position."
        )
    if run.options.quasi_static:
        return ConvergenceError(
            f"without inertia the motion ends at t = {time:g}: Newton finds no equilibrium after {iterations} iterations, with a step of "
            f"{step_length:.2g}; largest correction in {name}. At a limit point (snap-through) there is none nearby: only a run with "
            "inertia can follow, and statics names the point. Before one, try a smaller solver.step, or solver.local_error."
        )
    last = run.outcome.correction[LAST]
    what = (
        f"correction {last:.1e} > {tolerance:.1e}"
        if last > tolerance
        else f"correction {last:.1e}, but by factors that may leave more"
    )
    what = what if status == NOT_CONVERGED else "not finite"
    return ConvergenceError(
        f"Newton stopped at t = {time:g} after {iterations} iterations: {what}, largest in {name}. "
        f"Try a smaller solver.step (now {step_length:g}) or a smoother load curve."
    )


STEP_SAFETY, LEAST_SHRINKING, USUAL_SHRINKING, LARGEST_GROWTH, STEPS_PER_CHOICE = 0.8, 0.1, 0.25, 4.0, 50
"""Part of the length that the estimate allows; least and, where Newton failed, usual part of a rejected length; largest growth; most steps
before the length is looked at again."""
WORTHWHILE_GROWTH = 1.5
"""Growth for which the loop is stopped: Jacobians that were kept would have to be made anew."""
STEEPEST_GRADING = 10.0
"""Towards two stops that lie close together steps shrink by at most this: a joint's velocity error is a blow to a much shorter step."""
SMALLEST_STEP = 1e-9
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
    run = run._replace(
        control=run.control._replace(largest_error=allowed, easy_error=allowed * (STEP_SAFETY / WORTHWHILE_GROWTH) ** order)
    )
    chunks: list[tuple[np.ndarray, ...]] = [empty_history(run.system, 1, start)[:6]]
    times, h, places = [0.0], min(options.step, options.end_time), stops(run.system, options)
    for stop, after in pairwise([*places, np.inf]):
        while times[-1] < stop:
            most = max(STEEPEST_GRADING * (after - stop), (1 - 1 / STEEPEST_GRADING) * (stop - times[-1]))
            done, piece, chunk = _attempt(run, tuple(item[-1] for item in chunks[-1]), times[-1], stop, min(h, most))
            status, length = run.outcome.counts[STATUS], piece.lengths[0]
            if done:
                chunks.append(chunk)
                times += piece.times[1 : done + 1].tolist()
                run = run._replace(relaxation=piece.relaxation[done - 1 : done])
                check_memory(run.system, options, len(times))
            if status in (REJECTED, EASY):
                made = run.outcome.correction[LAST_ERROR if status == REJECTED else LATE_ERROR]
                ratio = STEP_SAFETY * (allowed / max(made, allowed / LARGEST_GROWTH**4)) ** (1 / order)
                found = length * np.clip(ratio, LEAST_SHRINKING, LARGEST_GROWTH)
                h = min(options.step, max(h, found) if status == EASY else found)  # a step to a stop may be shorter than need be
            elif status != CONVERGED:
                h = USUAL_SHRINKING * length
            if h < SMALLEST_STEP * options.end_time:
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
    needed = max(1, int(np.ceil((stop - time) / h * (1 - SMALLEST_STEP))))
    count = min(needed, STEPS_PER_CHOICE)
    length = (stop - time) / needed if needed <= STEPS_PER_CHOICE else h
    times = time + length * np.arange(count + 1)
    if needed == count:
        times[-1] = stop
    if length >= run.options.step * (1 - SMALLEST_STEP):
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
    end, shortest = options.end_time, SMALLEST_STEP * options.end_time
    inside = sorted({float(np.real(time)) for time in [*corners, *asked] if 0 < np.real(time) < end - shortest})
    return [*(time for before, time in pairwise([0.0, *inside]) if time - before > shortest), end]
