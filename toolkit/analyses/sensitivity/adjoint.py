"""Gradients by the discrete adjoint: one backward run for all design variables, exact for the discrete equations as the direct method.

    f = f(q_n, v_n, lam_n, x),   df/dx = f_x + sum over steps of mu_n^T R_x + (start's part)

Worth it where variables are many and responses few; `sensitivity.methods` and the command line offer it as a method.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import scipy

from toolkit.analyses.checkpoints import Checkpoint, checkpoint_states, solve_window, solve_windows, window_bounds
from toolkit.analyses.run_start import known_start, run_levels, run_motion
from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.preparation import (
    ANALYSES,
    Kind,
    Progress,
    by_name,
    check_kind,
    check_names,
    moving,
    price,
    responses_of,
    solve,
)
from toolkit.analyses.sensitivity.run import Run, run_of
from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions, step_lengths, time_grid
from toolkit.foundation.compiled.calls import in_memory
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.foundation.errors import NeedsDirectError, SingularSystemError
from toolkit.foundation.memory_sizes import GIGABYTE
from toolkit.foundation.processes import one_thread
from toolkit.foundation.value_types import Scalar
from toolkit.responses.response import Partials, Response
from toolkit.responses.windows import combine, steps_seen
from toolkit.scene.scene import Scene
from toolkit.solvers.start.initial_conditions import ConsistentMotion, State, rates_of_states
from toolkit.solvers.static.critical_state import refuse_gradients_of_critical
from toolkit.solvers.static.equilibrium import find_equilibrium, inputs_at, static_change, static_matrix
from toolkit.solvers.steady_state import steady_adjoint
from toolkit.solvers.transient.run import Integration, prepare_run
from toolkit.solvers.transient.scheme import EQUAL_STEPS, START, STEEPEST_GROWTH, Scheme, constraint_levels, relaxed, scheme_of
from toolkit.solvers.transient.step_gradients import AdjointMemory, adjoint_memory, integrate_backwards
from toolkit.system.equations import Plan
from toolkit.system.solution import Solution
from toolkit.system.system import System

STEPS_PER_COPY, COORDINATES_PER_COPY = 200, 30_000
"""Most steps whose states are copied at once, and between two reports of progress; and numbers of so many coordinates that the system
does not take their memory back after each copy."""


class BackwardSweep(NamedTuple):
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


def begin_sweep(system: System, options: RunOptions, times: np.ndarray, n_r: int) -> BackwardSweep:
    """Nothing swept yet; `times` (n_t,) are those of the run."""
    lengths = step_lengths(times)
    to_each = np.append(lengths[:1], lengths)
    ratios = np.append(1.0, to_each[1:] / to_each[:-1])
    ratios[np.abs(ratios - 1) <= EQUAL_STEPS] = 1.0
    ratios[ratios > STEEPEST_GROWTH] = 0.0
    memory = adjoint_memory(system.backward.plan, system.backward.gathered, system.lu_plan, system.weights, n_r)
    gradient, start = np.zeros((system.n_x, n_r)), np.zeros((3, 1, system.n))
    scheme, places = scheme_of(options), transposition(system)
    packed = in_memory(memory)
    return BackwardSweep(system, options, to_each, ratios, relaxed(to_each), scheme, places, memory, packed, gradient, start)


def sweep(
    state: BackwardSweep,
    window: Solution,
    first: int,
    found: Sequence[Partials],
    progress: Callable[[int], None] = lambda _: None,
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
    steps = min(STEPS_PER_COPY, 1 + COORDINATES_PER_COPY // state.system.n)
    for high in range(len(window.times), 0, -steps):
        piece = slice(max(0, high - steps), high)
        _sweep_piece(state, window, piece, first, found)
        progress(first + piece.start)


def _sweep_piece(state: BackwardSweep, window: Solution, piece: slice, first: int, found: Sequence[Partials]) -> None:
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
    state: BackwardSweep, plan: Plan, times: np.ndarray, steps: tuple, bounds: tuple[bool, bool], states: np.ndarray, by: tuple
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


def end_sweep(state: BackwardSweep) -> np.ndarray:
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


def _through_accelerations(state: BackwardSweep) -> None:
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


def fits(scene: Scene, system: System) -> bool:
    """Whether all states and the responses' partials by them, 8 n_t (3 n + n_r (n + n_q)) bytes, fit into `solver.memory`.

    A run that chooses its steps is not repeated in windows: it keeps all states, or refuses.
    """
    if scene.solver.local_error is not None:
        return True
    per_step = 3 * system.n + len(responses_of(scene)) * (system.n + system.n_q)
    return bool(8 * len(time_grid(scene.solver)) * per_step <= GIGABYTE * scene.solver.memory)


class Forwards(NamedTuple):
    """Results that a run in windows leaves behind."""

    run: Integration
    bounds: list[int]
    kept: list[Checkpoint]
    last: Solution  # the last window
    solution: Solution  # states at the checkpoints
    values: dict[str, Any]
    weights: dict[str, dict[int, float]]  # response -> window -> derivative of the response by that of the window


@one_thread()
def checkpointed_adjoint(compiled: Compiled, progress: Progress | None = None) -> Run:
    """Responses with gradients of a transient run, in the memory of about sqrt(n_t) states; the run is computed twice.

    Raises
    ------
    InputError
        As `adjoint_gradients`, or a response cannot be put together from windows.
    """
    tell = progress or (lambda *_: None)
    with watched_compilation() as first:
        forwards = run_forwards(compiled.primal, tell)
    with watched_compilation() as second:
        system = compiled.full
        gradients = by_name(system.design, forwards.values, run_backwards(system, forwards, tell).T)
    return run_of(forwards.solution, forwards.values, gradients, "adjoint", first.rest, second.rest)


def run_forwards(system: System, tell: Progress) -> Forwards:
    """Solve all windows in turn, and put the responses together from their values in the windows."""
    run, responses = prepare_run(system), responses_of(system.scene)
    bounds, kept, drift = window_bounds(len(run.times)), list[Checkpoint](), 0.0
    parts: dict[str, dict[int, Any]] = {name: {} for name in responses}
    for j, window in enumerate(solve_windows(run, bounds, kept)):
        drift = max(drift, window.drift)
        for name, seen in seen_responses(responses, window).items():
            parts[name][j] = seen.value(window)
        tell(bounds[j + 1], 2 * bounds[-1])
    values, weights = {}, {}
    for name, response in responses.items():
        values[name], found = combine(response, np.array(list(parts[name].values())))
        weights[name] = dict(zip(parts[name], found, strict=True))
    return Forwards(run, bounds, kept, window, checkpoint_states(run, bounds, kept, drift), values, weights)


def run_backwards(system: System, forwards: Forwards, tell: Progress) -> np.ndarray:
    """Gradients (n_x, n_r) of a system with design variables, by the backward sweep through all windows."""
    run, bounds, responses = forwards.run, forwards.bounds, responses_of(system.scene)
    state = begin_sweep(system, run.options, run.times, len(responses))
    for j in reversed(range(len(bounds) - 1)):
        last_one = j == len(bounds) - 2
        window = forwards.last if last_one else solve_window(run, forwards.kept[j], bounds[j], bounds[j + 1])[0]
        window = replace(window, system=system)
        seen = seen_responses(responses, window)
        weights = {name: weights.get(j, 0.0) for name, weights in forwards.weights.items()}
        found = [scaled(seen[name].partials(window), weights[name]) if name in seen else Partials(0.0) for name in responses]
        sweep(state, window, bounds[j] + int(j > 0), found)
        tell(2 * bounds[-1] - bounds[j], 2 * bounds[-1])
    return end_sweep(state)


def seen_responses(responses: Mapping[str, Response], window: Solution) -> dict[str, Response]:
    """Responses that look at any state of a window, by name."""
    first = int(np.searchsorted(window.whole_run, window.times[0]))
    last = first + len(window.times) - 1
    steps = {name: steps_seen(response, window.whole_run) for name, response in responses.items()}
    return {name: response for name, response in responses.items() if first <= steps[name][1] and steps[name][0] <= last}


def scaled(partials: Partials, weight: float) -> Partials:
    """Partial derivatives of a response, all times one number."""
    return Partials(partials.value, *(None if each is None else weight * each for each in partials[1:]))


NO_BACKWARD_RUN = 'stabilised index 2 (solver.formulation = "ggl") has no backward run'


def adjoint(scene: Scene, design: list[str], kind: Kind, progress: Progress | None = None, timed: bool = False) -> Run:
    """Responses with gradients by the discrete adjoint; parameters and errors as `sensitivity.direct.direct`.

    A run whose states exceed `solver.memory` is computed twice, in windows between checkpoints.

    Raises
    ------
    NeedsDirectError
        The formulation has no backward run, or a response needs derivatives of the states.
    """
    check_kind(kind)
    check_names(design)
    return by_adjoint(Compiled(scene, tuple(design)), kind, progress, timed)


def by_adjoint(compiled: Compiled, kind: Kind, progress: Progress | None = None, timed: bool = False) -> Run:
    """Responses of a compiled scene with gradients by the discrete adjoint."""
    scene = compiled.scene
    if not has_adjoint(scene, kind):
        raise NeedsDirectError(NO_BACKWARD_RUN)
    if kind == "transient" and not fits(scene, compiled.primal):
        return replace(checkpointed_adjoint(compiled, progress), repeat=partial(_again_in_windows, scene, compiled.names))
    with watched_compilation() as first:
        solution = ANALYSES[kind](compiled.primal, progress=progress)
    with watched_compilation() as second:
        found, gradient = adjoint_gradients(compiled.full, solution, progress)
    primal = price(first, timed, partial(solve, compiled.primal, kind))
    extra = price(second, timed, partial(adjoint_gradients, compiled.full, solution))
    values, gradients = _named(compiled.full, found, gradient)
    repeat = partial(again_backwards, compiled.primal, compiled.full, known_start(solution))
    return run_of(solution, values, gradients, "adjoint", primal, extra, repeat)


def again_backwards(
    primal: System, system: System, known: ConsistentMotion | State | None, options: RunOptions
) -> tuple[dict[str, Scalar], dict[str, dict[str, float]]]:
    """Values of a motion and gradients by the adjoint with other options, of a scene compiled without and with design variables; `known`
    as of `simulate`."""
    return _named(system, *adjoint_gradients(system, simulate(primal, options, known=known)))


def _named(
    system: System, found: dict[str, Partials], gradient: np.ndarray
) -> tuple[dict[str, Scalar], dict[str, dict[str, float]]]:
    """Values, and gradients (n_x, n_r), by the names of responses and variables."""
    return {name: partials.value for name, partials in found.items()}, by_name(system.design, found, gradient.T)


def _again_in_windows(
    scene: Scene, design: tuple[str, ...], options: RunOptions
) -> tuple[dict[str, float], dict[str, dict[str, float]]]:
    """The same where the states of the motion may not fit into memory."""
    found = adjoint(scene.model_copy(update={"solver": options}), list(design), "transient")
    return found.values, found.gradients


def has_adjoint(scene: Scene, kind: Kind) -> bool:
    """Whether a run of the scene can be differentiated backwards: all but those in stabilised index 2."""
    return kind == "static" or scene.solver.formulation != "ggl"


@one_thread()
def adjoint_gradients(
    system: System, solution: Solution, progress: Progress | None = None
) -> tuple[dict[str, Partials], np.ndarray]:
    """Partials of all responses of the scene, and their gradients (n_x, n_r).

    Parameters
    ----------
    system : System
        The scene compiled with the design variables.
    solution : Solution
        Of the same scene, with all states; derivatives in it only tell whether a length that is zero would grow.
    progress : callable
        Called with the steps done and the steps in all.

    Raises
    ------
    SingularSystemError
        A step's transposed equations have no unique solution.
    NeedsDirectError
        A response needs the states' own derivatives (a length that is zero), the run had a start of its own, or its formulation has no
        backward run.
    """
    options = solution.options or system.scene.solver
    if moving(solution) and options.formulation == "ggl":
        raise NeedsDirectError(NO_BACKWARD_RUN)
    if moving(solution) and solution.own_start:
        raise NeedsDirectError("the run has a start of its own, whose derivatives are unknown to the adjoint")
    seen = replace(solution, system=system)
    found = {name: response.partials(seen) for name, response in responses_of(system.scene, moving(solution)).items()}
    if not found:
        return found, np.zeros((system.n_x, 0))
    through = _through_time if moving(solution) else _through_steady_spin if solution.spins else _through_equilibrium
    return found, through(system, solution, list(found.values()), progress)


def _through_time(system: System, solution: Solution, found: list[Partials], progress: Progress | None) -> np.ndarray:
    """Backwards through all steps, then through the consistent start."""
    last = solution.steps
    state = begin_sweep(system, solution.options or system.scene.solver, solution.times, len(found))
    sweep(state, solution, 0, found, (lambda step: progress(last - step, last)) if progress else lambda _: None)
    return end_sweep(state)


def _through_steady_spin(system: System, solution: Solution, found: list[Partials], _: Progress | None) -> np.ndarray:
    """One transposed solve, see `steady_adjoint`."""
    sizes = {"q": system.n_q, "v": system.n_q, "a": system.n_q, "multipliers": system.n - system.n_q}
    parts = [[getattr(each, name) for each in found] for name in sizes]
    by = np.vstack(
        [
            np.column_stack([np.zeros(size) if slope is None else np.real(slope[0]) for slope in slopes])
            for size, slopes in zip(sizes.values(), parts, strict=True)
        ]
    )
    design = [np.zeros(system.n_x) if each.design is None else np.real(each.design) for each in found]
    options = solution.options or system.scene.solver
    return np.column_stack(design) + steady_adjoint(system, options, solution.q[0], solution.multipliers[0], by)


def _through_equilibrium(system: System, solution: Solution, found: list[Partials], _: Progress | None) -> np.ndarray:
    """A^T mu = - f_[q; lam], df/dx = f_x + (I_x + A_x)^T mu."""
    n_q, options = system.n_q, solution.options or system.scene.solver
    load, gradient = np.zeros((system.n, len(found))), np.zeros((system.n_x, len(found)))
    for r, partials in enumerate(found):
        load[:n_q, r] = 0 if partials.q is None else partials.q[0]
        load[n_q:, r] = 0 if partials.multipliers is None else partials.multipliers[0]
        gradient[:, r] = 0 if partials.design is None else partials.design
    q, rest = np.append(solution.q[0], np.zeros(system.n - n_q)), np.zeros(system.n)
    acc = np.append(np.zeros(n_q), solution.multipliers[0])
    refuse_gradients_of_critical(system, options, find_equilibrium(system, options, 1.0, q, acc)[0])
    inputs = inputs_at(system, options, 1.0)
    terms = system.evaluate(inputs, q, rest, acc, design=True)
    places = transposition(system)
    mu = static_change(system, inputs, q, acc, static_matrix(system, terms)[places], -load, "static adjoint", places)
    return gradient + (terms.I_x + terms.A_x).T @ mu
