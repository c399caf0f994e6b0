"""The adjoint of a run whose states do not fit into memory: forwards in windows, and backwards through windows computed again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from toolkit.analyses.checkpoints import Checkpoint, checkpoint_states, solve_window, solve_windows, window_bounds
from toolkit.description.time_grid import time_grid
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.foundation.memory_sizes import GIGABYTE
from toolkit.foundation.processes.one_thread import one_thread
from toolkit.responses.response import Partials, Response
from toolkit.responses.windows import combine, steps_seen
from toolkit.scene.scene import Scene
from toolkit.sensitivity.adjoint.backward_sweep import begin_sweep, end_sweep, sweep
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.evaluation import by_name
from toolkit.sensitivity.preparation import Progress, responses_of
from toolkit.sensitivity.run import Run, run_of
from toolkit.solvers.transient.run import Integration, prepare_run
from toolkit.system.solution import Solution
from toolkit.system.system import System


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
