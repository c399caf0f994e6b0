"""From partial derivatives of responses by the states of a run to their gradients by the design: backwards, window by window."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy

from toolkit.analyses.run_start import run_levels, run_motion
from toolkit.description.run_options import RunOptions
from toolkit.description.time_grid import step_lengths
from toolkit.equations.equations import Plan
from toolkit.foundation.compiled.calls import in_memory
from toolkit.foundation.errors import SingularSystemError
from toolkit.responses.response import Partials
from toolkit.solvers.start.initial_conditions import State, rates_of_states
from toolkit.solvers.transient.adjoint_steps import AdjointMemory, adjoint_memory, integrate_backwards
from toolkit.solvers.transient.formulation import constraint_levels, relaxed, scheme_of
from toolkit.solvers.transient.prediction import SAME, STEEP
from toolkit.solvers.transient.scheme import START, Scheme
from toolkit.system.solution import Solution
from toolkit.system.system import System

PIECE, SMALL = 200, 30_000
"""Most steps whose states are copied at once, and between two reports of progress; and numbers of so many coordinates that the system
does not take their memory back after each copy."""


class Sweep(NamedTuple):
    """What all steps of a backward run share, what one leaves to the one before, and the gradient (n_x, n_r) that grows."""

    system: System
    options: RunOptions
    lengths: np.ndarray  # (n_t,) of the step to each state of the run, that to the start like the one after it
    ratios: np.ndarray  # (n_t,) see `step_ratio`
    relaxation: np.ndarray  # (n_t,) see `relaxed`
    scheme: Scheme
    transposition: np.ndarray
    memory: AdjointMemory
    packed: Any  # the same as compiled code takes it
    gradient: np.ndarray
    start: np.ndarray  # (3, 1, n) q, v and [a; lam] of the start, once the sweep is there


def begin_sweep(system: System, options: RunOptions, times: np.ndarray, n_r: int) -> Sweep:
    """Nothing swept yet; `times` (n_t,) are those of the run."""
    lengths = step_lengths(times)
    to_each = np.append(lengths[:1], lengths)
    ratios = np.append(1.0, to_each[1:] / to_each[:-1])
    ratios[np.abs(ratios - 1) <= SAME] = 1.0
    ratios[ratios > STEEP] = 0.0
    memory = adjoint_memory(system.backward.plan, system.backward.gathered, system.lu_plan, system.weights, n_r)
    gradient, start = np.zeros((system.n_x, n_r)), np.zeros((3, 1, system.n))
    scheme, places = scheme_of(options), transposition(system)
    packed = in_memory(memory)
    return Sweep(system, options, to_each, ratios, relaxed(to_each), scheme, places, memory, packed, gradient, start)


def sweep(
    state: Sweep, window: Solution, first: int, found: Sequence[Partials], progress: Callable[[int], None] = lambda _: None
) -> None:
    """Go backwards through a window whose first state is that of step `first`; `found` are partials by the window's states.

    `progress` is called with the step that is reached.

    Raises
    ------
    SingularSystemError
        A step's transposed equations have no unique solution.
    """
    for r, partials in enumerate(found):
        state.gradient[:, r] += 0 if partials.design is None else partials.design
    steps = min(PIECE, 1 + SMALL // state.system.n)
    for high in range(len(window.times), 0, -steps):
        piece = slice(max(0, high - steps), high)
        _sweep_piece(state, window, piece, first, found)
        progress(first + piece.start)


def _sweep_piece(state: Sweep, window: Solution, piece: slice, first: int, found: Sequence[Partials]) -> None:
    system, steps = state.system, slice(first + piece.start, first + piece.stop)
    begins, ends = steps.start == 0, steps.stop == len(window.whole_run)
    by = tuple(_stacked(system, piece, found, *names) for names in (("q",), ("v",), ("a", "multipliers")))
    levels = constraint_levels(state.options, state.lengths[steps], state.relaxation[steps])
    states = _padded(system, window, piece)
    if begins:
        state.start[:] = states[:, :1]
    _run_back(
        state, system.backward.plan, window.times[piece], (state.lengths[steps], state.ratios[steps], levels, state.scheme),
        (begins, ends), states, by,
    )  # fmt: skip


def _run_back(
    state: Sweep, plan: Plan, times: np.ndarray, steps: tuple, bounds: tuple[bool, bool], states: np.ndarray, by: tuple
) -> None:
    system = state.system
    failed = system.run(
        integrate_backwards, system.evaluator, plan, system.functions, *system.curves(times), *steps, state.transposition, *bounds,
        *states, *by, state.packed, state.gradient,
    )  # fmt: skip
    if failed >= 0:
        raise SingularSystemError(
            f"the transposed equations of a step do not determine {system.numbering.names[failed]}. Use the direct method, whose "
            "solution the run has shown to exist, or remove redundant joints."
        )


def end_sweep(state: Sweep) -> np.ndarray:
    """The start's part added: the gradient (n_x, n_r)."""
    system, n_r = state.system, state.gradient.shape[1]
    q_bar, v_bar, acc_bar = (each[:, :n_r] for each in state.memory.bars[:3])
    start = run_motion(system, state.options)
    if isinstance(start, State):
        parts = [(q_bar, start.dq), (v_bar, start.dv), (acc_bar, start.dacc)]
    else:
        _through_accelerations(state)
        _, dv = rates_of_states(system, start.q, start.dq, start.v, start.dv, 0.0)  # those of the loads' own states too
        parts = [(q_bar, start.dq), (v_bar, dv)]
    for bar, change in parts:
        if np.any(change):
            state.gradient[:] += change.T @ bar
    state.gradient[:] += system.backward.gradient(state.memory.sums)
    return state.gradient


def _through_accelerations(state: Sweep) -> None:
    """Back from [a; lam] of the start to its coordinates and velocities, as a step of no length.

    States of loads have no mass, and start without acceleration, whatever the design is.
    """
    system, nothing = state.system, np.zeros((1, state.system.n, state.gradient.shape[1]))
    plan, states = system.backward.plan, system.numbering.states
    if len(states):
        plan = plan._replace(dropped=np.concatenate([plan.dropped, states]))
    state.memory.bars.aux[:] = 0
    steps = np.zeros(1), np.ones(1), run_levels(state.options)[None], START
    _run_back(state, plan, np.zeros(1), steps, (False, True), state.start, (nothing,) * 3)


def _padded(system: System, window: Solution, piece: slice) -> np.ndarray:
    """q, v and [a; lam] of some states, (3, n_t, n)."""
    states, n_q = np.zeros((3, piece.stop - piece.start, system.n)), system.n_q
    states[:, :, :n_q] = window.q[piece], window.v[piece], window.a[piece]
    states[2, :, n_q:] = window.multipliers[piece]
    return states


def _stacked(system: System, piece: slice, found: Sequence[Partials], *names: str) -> np.ndarray:
    """Some kinds of partial derivatives of all responses, at their places among the unknowns: (n_t, as many rows as needed, n_r)."""
    given = [(r, name, by) for name in names for r, each in enumerate(found) if (by := getattr(each, name)) is not None]
    ends = {"multipliers": system.n}
    stacked = np.zeros(
        (piece.stop - piece.start, max((ends.get(name, system.n_q) for _, name, _ in given), default=0), len(found))
    )
    for r, name, by in given:
        where = slice(system.n_q, None) if name == "multipliers" else slice(0, system.n_q)
        stacked[:, where, r] = np.real(by[piece])
    return stacked


def transposition(system: System) -> np.ndarray:
    """Place of the transposed entry of every entry of the pattern, which is symmetric: (n_entries,)."""
    columns, starts = system.plan.indices, system.plan.indptr
    places: np.ndarray = (
        scipy.sparse.csr_array((np.arange(len(columns)), columns, starts), shape=(system.n, system.n)).tocsc().data
    )
    return places
