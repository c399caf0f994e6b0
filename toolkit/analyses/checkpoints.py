"""A run in windows: only what one window leaves to the next is kept, so that any window can be computed again.

With n steps in windows of about sqrt(n), neither the checkpoints nor one window's states take more than sqrt(n) states' memory. A window
that is computed again has the same bits as the first time: every step finds the same numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from toolkit.analyses.run_start import run_start
from toolkit.analyses.transient import advance, check_drift
from toolkit.solvers.start.initial_conditions import State
from toolkit.solvers.transient.run import Integration, empty_history
from toolkit.solvers.transient.step_memory import ALL_ITERATIONS, LARGEST, Memory
from toolkit.system.solution import Solution
from toolkit.validity.judge import judge


class Checkpoint(NamedTuple):
    """A state and what its step leaves to the next, (n,) where nothing else is said."""

    q: np.ndarray
    v: np.ndarray
    acc: np.ndarray
    aux: np.ndarray  # auxiliary acceleration w
    carried: np.ndarray  # part of the next residual
    trend: np.ndarray  # (HIGHEST, n) what the first guess of the next step is made of
    fitted: np.ndarray  # (HIGHEST,) multiples of that
    fit_sums: np.ndarray  # (HIGHEST, LANES)
    learnt: np.ndarray  # (10,) and what Newton knows of the equations


def window_bounds(n_t: int) -> list[int]:
    """Steps at which windows begin, and the last step."""
    steps = n_t - 1
    length = int(np.ceil(np.sqrt(steps)))
    return [*range(0, steps, length), steps]


def solve_windows(run: Integration, bounds: list[int], kept: list[Checkpoint]) -> Iterator[Solution]:
    """States of a run without design variables, window by window; appends the checkpoints before each window and after the last.

    Raises
    ------
    InputError, SingularSystemError, ConvergenceError
        As `simulate`.
    """
    start, zero = run_start(run.system, run.options), np.zeros(run.system.n)
    kept.append(Checkpoint(start.q, start.v, start.acc, zero, zero, *_guesses(run.memory)))
    for first, last in pairwise(bounds):
        window, after = solve_window(run, kept[-1], first, last)
        kept.append(after)
        yield window


def solve_window(run: Integration, checkpoint: Checkpoint, first: int, last: int) -> tuple[Solution, Checkpoint]:
    """States of steps first + 1 ... last, and at the beginning of the run also the start; and the checkpoint behind them."""
    system, memory = run.system, run.memory
    memory.aux[:], memory.carried[:], memory.span[0] = checkpoint.aux, checkpoint.carried, run.lengths[first - 1]
    memory.trend[:], memory.learnt[:] = checkpoint.trend, checkpoint.learnt
    memory.fitted[:], memory.fit_sums[:] = checkpoint.fitted, checkpoint.fit_sums
    derivatives = (np.zeros((system.n, 0)),) * 3
    history = empty_history(system, last - first + 1, State(checkpoint.q, checkpoint.v, checkpoint.acc, *derivatives))
    advance(run, history, first)
    drift, skipped = check_drift(run, history.q, first), int(first > 0)
    end = (history.q[-1], history.v[-1], history.acc[-1], memory.aux, memory.carried)
    after = Checkpoint(*(array.copy() for array in end), *_guesses(memory))
    states = tuple(array[skipped:] for array in history[:6])
    return selected(run, states, range(first + skipped, last + 1), drift), after


def _guesses(memory: Memory) -> tuple[np.ndarray, ...]:
    """Copies of the arrays of the step memory that first guesses are made of."""
    return memory.trend.copy(), memory.fitted.copy(), memory.fit_sums.copy(), memory.learnt.copy()


def checkpoint_states(run: Integration, bounds: list[int], kept: list[Checkpoint], drift: float) -> Solution:
    """States at the checkpoints: all that is left of the run."""
    states = [np.stack([getattr(each, name) for each in kept]) for name in ("q", "v", "acc")]
    derivatives = [np.zeros((*states[0].shape, 0))] * 3
    return selected(run, (*states, *derivatives), bounds, drift)


def selected(run: Integration, states: tuple[np.ndarray, ...], steps: range | list[int], drift: float) -> Solution:
    """Solution that holds the states of some steps of a run."""
    return Solution.from_padded(
        run.system,
        run.times[steps],
        states,
        drift=drift,
        correction=float(run.outcome.correction[LARGEST]),
        local_error=run.largest_local_error,
        options=run.options,
        newton_iterations=int(run.outcome.counts[ALL_ITERATIONS]),
        run_times=run.times,
        judge=judge,
    )
