"""The steady state of a scene that spins, as a solution; and its modes."""

from __future__ import annotations

import numpy as np

from toolkit.analyses.modes_found import Modes
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import SingularSystemError
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.solvers.dense_memory import check_dense
from toolkit.solvers.free_motions import free_motions
from toolkit.solvers.roots import VIBRATES, all_roots, count_of_zeros, counts, frequency_of, refined
from toolkit.solvers.spin.axis import spin_of
from toolkit.solvers.spin.constancy import refuse_what_changes
from toolkit.solvers.spin.generator import angular_velocity, generator
from toolkit.solvers.spin.state import linearised
from toolkit.solvers.spin.steady_state import steady_state
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.system.solution import Solution
from toolkit.system.system import System
from toolkit.validity.bodies.frequencies import cautions_of_modes
from toolkit.validity.judge import judge

DAMPED = 1e-6
"""Real part of a root, in parts of its size, below which it is round-off: of two roots that are nearly one it is the root of it."""


def solve_spinning(
    system: System, options: RunOptions | None = None, speed: float | None = None, known: Solution | None = None
) -> Solution:
    """The steady state of a scene that a driver spins, under the loads at the end time; with its design derivatives.

    Every body turns with the driver, about its axis, and deforms under its own inertia.

    Parameters
    ----------
    system
        The compiled scene.
    options
        By default the scene's own.
    speed
        In rad/time, instead of the driver's; then design derivatives are left out.
    known
        A steady state of the same scene next to it, to begin in.

    Raises
    ------
    InputError
        Nothing says the speed, or the scene cannot turn as a whole, or is not the same at every angle.
    ConvergenceError, SingularSystemError
        There is no steady state, or something is free to move in the frame that spins.
    """
    options = options or system.scene.solver
    check_dense(system, options)
    n_q = system.n_q
    beside = None if known is None else (known.q[-1].astype(system.dtype), known.multipliers[-1].astype(system.dtype))
    found = steady_state(system, options, speed, beside)
    inputs = system.inputs(options.end_time, LEVELS)
    spin = spin_of(system, options, inputs)
    motion = spin.generator(system).times(found.speed / spin.speed)
    if system.compiled:
        refuse_what_changes(system, inputs, motion, found.speed, found.q)
    return Solution(
        system, np.array([options.end_time]), found.q[None], found.v[None], found.acc[None, :n_q], found.acc[None, n_q:],
        found.dq[None], found.dv[None], found.dacc[None, :n_q], found.dacc[None, n_q:], options=options, judge=judge,
        load_steps=found.steps, newton_iterations=found.iterations,
    )  # fmt: skip


def spinning_modes(solution: Solution, count: int | None = None) -> Modes:
    """Modes about a steady spin, as they are seen from the frame that spins, with gyroscopic and centrifugal forces and with dampers.

        (s^2 M + s C + K) u = 0,   J u = 0,   see `solvers.spin.state.Linearised.spinning`

    Raises
    ------
    SingularSystemError
        The joints leave no motion.
    """
    system, n_q = solution.system, solution.system.n_q
    q, v = solution.q[-1], solution.v[-1]
    omega = angular_velocity(system, q, v)
    motion = generator(system, omega, np.zeros(system.scene.dimension)).matrix
    acc = np.concatenate([solution.a[-1], solution.multipliers[-1]])
    whole = linearised(system, system.inputs(solution.times[-1], LEVELS), q, v, acc)
    free = free_motions(whole.by_acc[:n_q, n_q:].T, system.weights[:n_q])
    if not free.shape[1]:
        raise SingularSystemError("the joints leave no motion, so there are no modes. Remove a joint or a driver.")
    K, C, M = (free.T @ each[:n_q, :n_q] @ free for each in whole.spinning(motion))
    values, left, right = all_roots(K, C, M)
    largest = float(np.abs(values).max())
    chosen = [k for k in range(len(values)) if counts(values[k], largest)]
    roots, shapes = [], []
    for k in chosen:
        s, u, _ = refined(K, C, M, values[k], right[:, k], left[:, k])
        near = abs(s - values[k]) < 0.1 * abs(values[k])
        roots.append(s if near else values[k])
        shapes.append(free @ (u if near else right[:, k]))
    zeros = count_of_zeros(values, largest)
    order = np.argsort([frequency_of(s) for s in roots], kind="stable")
    frequencies = np.array([frequency_of(roots[k]) for k in order])
    ratios = np.array([-roots[k].real / abs(roots[k]) for k in order])
    ratios[np.abs(ratios) < DAMPED] = 0.0
    place = int(np.searchsorted(frequencies, 0.0))
    frequencies, ratios = np.insert(frequencies, place, [0.0] * zeros), np.insert(ratios, place, [0.0] * zeros)
    columns = [_scaled(shapes[k], system.weights[:n_q]) for k in order]
    columns[place:place] = [np.zeros(n_q)] * zeros
    cautions = [*_cautions(np.array(roots)), *cautions_of_modes(solution, frequencies[:count], count)]
    return Modes(frequencies[:count], np.column_stack(columns)[:, :count], Verdict.of(cautions), ratios[:count])


def _scaled(shape: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Mode shape divided by its entry for the coordinate that moves most, in comparable units, so that this entry is real."""
    place = int(np.argmax(weights * np.abs(shape)))
    return shape / shape[place]


def _cautions(roots: np.ndarray) -> list[Caution]:
    growing = roots[roots.real > DAMPED * np.abs(roots)]
    if not len(growing):
        return []
    worst = growing[np.argmax(growing.real)]
    what = f"vibrates with {worst.imag / (2 * np.pi):.4g} Hz and" if worst.imag > VIBRATES * abs(worst) else "runs away and"
    return [
        Caution(
            "unstable",
            f"this spin is unstable: a small disturbance {what} grows like exp({worst.real:.4g} t). A real scene would not stay in it; "
            "spin it slower, or stiffen what grows.",
        )
    ]
