"""The steady state of a spinning scene: coordinates that are constant in a frame which turns with the scene.

    R(q, v, a, lam) = 0    with    v = S q + s,   a = S v

where the loads are those at the end time. Loads and centrifugal forces grow in proportion from nothing, so that Newton finds its way.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError, InputError, SingularSystemError, retold
from toolkit.foundation.near_ties import first_largest
from toolkit.solvers.spin_axis import Generator, SceneSpin, balancing, linearised, moved, refuse_acceleration, spin_of
from toolkit.solvers.static.equilibrium import COORDINATE_ROUNDINGS, LEVELS, ROUND_OFF
from toolkit.system.equations import Inputs
from toolkit.system.system import System

SMALLEST_STEP = 2.0**-10
"""Part of the load, and of the square of the speed, below which a step is given up."""
DIRECT_NEWTON_DISTANCE = 0.05
"""Part of the model size (or rad) that a state may be off a known one from which Newton goes straight to it."""
SINGULAR_MATRIX = 1e-14
"""Smallest singular value of the matrix, in comparable units, in parts of the largest, which is round-off."""
RATES = np.array([0.0, 1.0, 0.0])
JOINT_OPENING = 1e-9
"""Part of the model size per radian by which a joint may open, above round-off."""


class SteadyState(NamedTuple):
    """A steady state: coordinates and velocities (n_q,), [a; lam] (n,), derivatives (..., n_x), speed, steps, iterations."""

    q: np.ndarray
    v: np.ndarray
    acc: np.ndarray
    dq: np.ndarray
    dv: np.ndarray
    dacc: np.ndarray
    speed: float
    steps: int
    iterations: int


def steady_state(
    system: System, options: RunOptions, speed: float | None = None, known: tuple[np.ndarray, np.ndarray] | None = None
) -> SteadyState:
    """Steady state under the loads at the end time.

    Parameters
    ----------
    speed
        In rad/time, instead of that of the driver; its sense is that of the driver.
    known
        Coordinates (n_q,) and multipliers of a state next to it, to begin in.

    Raises
    ------
    InputError
        No driver says the speed, it changes then, or joints do not let the scene turn as a whole.
    ConvergenceError, SingularSystemError
        There is no steady state that Newton finds, or something is free to move in the frame that turns.
    """
    inputs = system.inputs(options.end_time, LEVELS)
    spin = spin_of(system, options, inputs)
    if speed is None:
        refuse_acceleration(spin, inputs, options)
    factor = 1.0 if speed is None else speed / spin.speed
    motion, begin = spin.generator(system).times(factor), _turned_start(system, inputs, spin)
    _refuse_before(system, inputs, spin)
    near = None if known is None else _near(system, options, inputs, motion, *known)
    q, multipliers, steps, iterations = near or _from_rest(system, options, inputs, motion, begin)
    _refuse_joints_that_open(system, inputs, spin, q)
    derivatives = _derivatives(system, inputs, spin, motion, q, multipliers)
    v, acc = moved(motion, q, multipliers)
    return SteadyState(q, v, acc, *derivatives, np.abs(factor) * spin.speed, steps, iterations)


def _near(
    system: System, options: RunOptions, inputs: Inputs, motion: Generator, q: np.ndarray, multipliers: np.ndarray
) -> tuple[np.ndarray, np.ndarray, int, int] | None:
    """Steady state close to given coordinates, as `_from_rest` has it; None if Newton does not go straight to it."""
    try:
        found, forces, count = _newton(system, options, inputs, motion, 1.0, q, multipliers)
    except (ConvergenceError, SingularSystemError):
        return None
    way = system.weights[: system.n_q] * np.abs(np.real(found - q))
    return (found, forces, 0, count) if way.max(initial=0) < DIRECT_NEWTON_DISTANCE else None


def _from_rest(
    system: System, options: RunOptions, inputs: Inputs, motion: Generator, q: np.ndarray
) -> tuple[np.ndarray, np.ndarray, int, int]:
    """Coordinates and multipliers at full load and speed, steps and iterations."""
    reached, step, steps, iterations = 0.0, 1.0 / options.load_steps, 0, 0
    multipliers = None
    while reached < 1:
        part = 1.0 if reached + step > 1 - SMALLEST_STEP else reached + step
        begin = _balancing(system, inputs, motion, part, q) if multipliers is None else multipliers * (part / reached)
        try:
            q, multipliers, count = _newton(system, options, inputs, motion, part, q, begin)
        except (ConvergenceError, SingularSystemError) as error:
            step /= 2
            if step < SMALLEST_STEP:
                raise retold(
                    error,
                    f"there is no steady spin beyond {100 * reached:.4g} % of the load and of the square of the speed: {error}",
                ) from error
            continue
        reached, steps, iterations = part, steps + 1, iterations + count
    assert multipliers is not None
    return q, multipliers, steps, iterations


def _newton(
    system: System, options: RunOptions, inputs: Inputs, motion: Generator, part: float, q: np.ndarray, multipliers: np.ndarray
) -> tuple[np.ndarray, np.ndarray, int]:
    """Newton's iteration at a part of the loads and of the square of the speed, down to round-off."""
    slower = motion.times(np.sqrt(part))
    inputs, n_q, size = inputs._replace(scale=part), system.n_q, np.inf
    far = (system.weights[:n_q] * np.abs(np.real(q))).max(initial=0)
    reachable = max(options.tolerance, ROUND_OFF, COORDINATE_ROUNDINGS * ROUND_OFF * far)
    for iteration in range(2 * options.max_iterations):
        there = linearised(system, inputs, q, *moved(slower, q, multipliers))
        correction = _solve(system, there.spinning(slower.matrix)[0], there.residual)
        q, multipliers = q - correction[:n_q], multipliers - correction[n_q:]
        before, size = size, (system.weights[:n_q] * np.abs(np.real(correction[:n_q]))).max(initial=0)
        if not np.isfinite(size) or size > 1 / ROUND_OFF:
            break
        if (size <= reachable and size > 0.5 * before) or size <= ROUND_OFF:
            return q, multipliers, iteration + 1
    raise ConvergenceError(
        f"Newton did not converge to a steady spin: its correction is {size:.1e} of the model size (or rad), largest in "
        f"{system.most_moved(correction)}. Spin slower, or give positions nearer to those of the spin."
    )


def _solve(system: System, matrix: np.ndarray, rhs: np.ndarray) -> np.ndarray:
    """Solution of a dense linear system in comparable units.

    Raises
    ------
    SingularSystemError
        Names what is free to move.
    """
    columns = np.append(1 / system.weights[: system.n_q], np.ones(system.n - system.n_q))
    scaled = columns[:, None] * matrix * columns
    rows = np.abs(scaled).max(axis=1)
    across = np.abs(scaled / np.where(rows > 0, rows, 1)[:, None]).max(axis=0)
    scaled = scaled / np.where(rows > 0, rows, 1)[:, None] / np.where(across > 0, across, 1)
    _, sizes, vectors = np.linalg.svd(np.real(scaled))
    if not sizes[-1] > SINGULAR_MATRIX * sizes[0]:
        free = np.abs(vectors[-1])[: system.n_q]
        raise SingularSystemError(
            f"nothing determines {system.numbering.names[first_largest(free)] if free.size else 'the joint forces'} in the frame that "
            "spins with the scene, or joints repeat each other. Add a joint or a spring, or remove the joints that repeat each other."
        )
    lines = columns / np.where(rows > 0, rows, 1)
    solved = (
        np.linalg.solve(scaled, lines[:, None] * rhs.reshape(system.n, -1)) * (columns / np.where(across > 0, across, 1))[:, None]
    )
    return solved.reshape(rhs.shape)


def _balancing(system: System, inputs: Inputs, motion: Generator, part: float, q: np.ndarray) -> np.ndarray:
    """Multipliers that come nearest to balancing loads and centrifugal forces."""
    n_q = system.n_q
    slower = motion.times(np.sqrt(part))
    there = linearised(system, inputs._replace(scale=part), q, *moved(slower, q, np.zeros(system.n - n_q)))
    return balancing(system, there.by_acc[:n_q, n_q:], there.residual[:n_q])


def _turned_start(system: System, inputs: Inputs, spin: SceneSpin) -> np.ndarray:
    """Given positions of the scene, turned with the driver to the end time."""
    whole = spin.generator(system)
    real = Generator(np.real(whole.matrix), np.real(whole.offset))
    angle, rate = (
        np.real(inputs.curves[spin.curve] - system.inputs(0.0, LEVELS).curves[spin.curve])[0],
        inputs.curves[spin.curve][1],
    )
    found: np.ndarray = real.turned(np.real(system.start()[0][: system.n_q]), float(angle / np.real(rate)))[0]
    return found.astype(system.dtype)


def _refuse_before(system: System, inputs: Inputs, spin: SceneSpin) -> None:
    """Refuse joints that open in the given positions, if they are closed there.

    This comes before Newton looks for a state that does not exist.
    """
    given = system.start()[0][: system.n_q]
    gaps = linearised(system, system.inputs(0.0, LEVELS), given, 0 * given, np.zeros(system.n)).residual[system.n_q :]
    if (system.weights[system.n_q :] * np.abs(np.real(gaps))).max(initial=0) < JOINT_OPENING:
        _refuse_joints_that_open(system, inputs, spin, given)


def _refuse_joints_that_open(system: System, inputs: Inputs, spin: SceneSpin, q: np.ndarray) -> None:
    """Refuse a joint that does not let the scene turn as its driver asks."""
    n_q, velocity = system.n_q, spin.generator(system).velocity(q)
    rates = linearised(system, inputs._replace(levels=RATES), q, velocity, np.zeros(system.n)).residual[n_q:]
    off = np.abs(np.real(rates)) / spin.speed * system.weights[n_q:]
    if off.max(initial=0) > JOINT_OPENING:
        name = system.numbering.names[n_q + first_largest(off)]
        raise InputError(
            f"the scene cannot spin as a whole about the axis of its driver: {name} does not let it. Only bodies that turn with the "
            "driver, and the ground, can take part in a steady spin. Move the joint onto the axis, or simulate the scene."
        )


class Explicit(NamedTuple):
    """Derivatives by the design at held coordinates and multipliers: v (n_q, n_x), a (n_q, n_x), the residual (n, n_x)."""

    v: np.ndarray
    a: np.ndarray
    residual: np.ndarray


def _explicit(
    system: System, inputs: Inputs, spin: SceneSpin, motion: Generator, q: np.ndarray, multipliers: np.ndarray
) -> tuple[Explicit, np.ndarray]:
    """Derivatives at held coordinates and multipliers, and the matrix (n, n) of the equations of [q; lam]."""
    v, acc = moved(motion, q, multipliers)
    there = linearised(system, inputs, q, v, acc)
    by_v, by_a = np.zeros((system.n_q, system.n_x)), np.zeros((system.n_q, system.n_x))
    for x, change in enumerate(spin.generator_changes(system)):
        by_v[:, x] = change.velocity(q)
        by_a[:, x] = change.matrix @ v + motion.matrix @ by_v[:, x]
    residual = there.by_x + there.by_v @ by_v + there.by_acc[:, : system.n_q] @ by_a
    return Explicit(by_v, by_a, residual), there.spinning(motion.matrix)[0]


def _derivatives(
    system: System, inputs: Inputs, spin: SceneSpin, motion: Generator, q: np.ndarray, multipliers: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Design derivatives of q, v and [a; lam]."""
    n_q, S = system.n_q, motion.matrix
    if not system.n_x:
        return np.zeros((n_q, 0)), np.zeros((n_q, 0)), np.zeros((system.n, 0))
    explicit, matrix = _explicit(system, inputs, spin, motion, q, multipliers)
    moves = _solve(system, matrix, -explicit.residual)
    dq = moves[:n_q]
    return dq, explicit.v + S @ dq, np.vstack([explicit.a + S @ S @ dq, moves[n_q:]])


def steady_adjoint(system: System, options: RunOptions, q: np.ndarray, multipliers: np.ndarray, by: np.ndarray) -> np.ndarray:
    """Design derivatives (n_x, n_r) of numbers with derivatives `by` q, v, a and multipliers, one below the other, (3 n_q + n_lam, n_r).

        A^T mu = [f_q + S^T f_v + S^2^T f_a; f_lam],   df/dx = f_v . v_x + f_a . a_x - mu . R_x

    at the coordinates (n_q,) and multipliers of a steady state with the driver's speed.
    """
    n_q, inputs = system.n_q, system.inputs(options.end_time, LEVELS)
    spin = spin_of(system, options, inputs)
    motion = spin.generator(system)
    explicit, matrix = _explicit(system, inputs, spin, motion, q, multipliers)
    f_q, f_v, f_a, f_lam = np.split(by, [n_q, 2 * n_q, 3 * n_q])
    S = motion.matrix
    mu = _solve(system, matrix.T, np.vstack([f_q + S.T @ f_v + (S @ S).T @ f_a, f_lam]))
    found: np.ndarray = explicit.v.T @ f_v + explicit.a.T @ f_a - explicit.residual.T @ mu
    return found
