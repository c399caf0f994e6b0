"""Stiffness, damping and mass of small motions about an equilibrium or a steady spin, and their roots.

A vibration u exp(s t) in the frame that spins changes the coordinates by u, velocities by (S + s) u, accelerations by (S + s)^2 u, with
S of `solvers.spin.generator`. Its equations are the residual's derivative along that direction, and mixed derivatives commute.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.foundation.errors import InputError, SingularSystemError
from toolkit.foundation.kernel import plain
from toolkit.solvers.free_motions import all_roots, free_motions, is_zero, refined
from toolkit.solvers.spin_axis import Linearised, angular_velocity, generator, linearised, of_terms
from toolkit.solvers.static.equilibrium import LEVELS, static_matrix
from toolkit.system.equations import Inputs, Terms, allocate_terms, allocate_work, evaluate_all, of_variables
from toolkit.system.evaluation import plain_formulas_of
from toolkit.system.solution import Solution

STEP = 1e-30
"""Complex step: far below round-off."""


class Pencil(NamedTuple):
    """Stiffness K (n, n) of coordinates and multipliers, damping C and mass M (n, n), zero but for the coordinates."""

    stiffness: np.ndarray
    damping: np.ndarray
    mass: np.ndarray


def pencil_of(solution: Solution, inputs: Inputs | None = None) -> Pencil:
    """Stiffness, damping and mass at the equilibrium that a solution ends in, under its final loads or other `inputs`."""
    system, n_q = solution.system, solution.system.n_q
    terms = system.evaluate(inputs or system.inputs(solution.times[-1], LEVELS), *_state(solution))
    stiffness, damping, mass = (system.dense(each) for each in (static_matrix(system, terms), terms.A_v, terms.I_acc))
    for each in (damping, mass):
        each[n_q:], each[:, n_q:] = 0, 0
    return Pencil(stiffness, damping, mass)


def real_pencil(pencil: Pencil) -> Pencil:
    """Real parts of the three matrices of a pencil."""
    return Pencil(*(np.real(each) for each in pencil))


def pencil_change(
    solution: Solution, s: complex, u: np.ndarray, w: np.ndarray, damped: bool, inputs: Inputs | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of w^T (s^2 dM + s dC + dK) u by q and multipliers (n,), and by the design (n_x,).

    Mixed derivatives commute: w^T dK/dz_j u is what K changes by along u, transposed, times w; one complex step along u gives it exactly,
    for all z_j and the design at once, and one of the velocities along u does the same for C.
    """
    system, n_q = solution.system, solution.system.n_q
    q, v, acc = (np.real(each) for each in _state(solution))
    by_z, by_x = np.zeros(system.n, complex), np.zeros(system.n_x, complex)
    of_q = np.arange(system.n) < n_q
    for part, factor in ((np.real(u), 1.0), (np.imag(u), 1j)):
        motion, force = np.where(of_q, part, 0), np.where(of_q, 0, part)
        along = plain_terms(solution, q + 1j * STEP * motion, v, acc + 1j * STEP * force, inputs)
        by_z += factor * (w @ system.matrix(np.imag(static_matrix(system, along)) / STEP))
        by_x += factor * (w @ np.imag(along.I_x + along.A_x) / STEP)
        moving = plain_terms(solution, q, v, motion, inputs)
        by_z[:n_q] += factor * s * s * (w @ system.matrix(np.real(moving.I_q)))[:n_q]
        by_x += factor * s * s * (w[:n_q] @ np.real(moving.I_x)[:n_q])
        if damped:
            rate = plain_terms(solution, q, v + 1j * STEP * motion, acc, inputs)
            by_z[:n_q] += factor * s * (w @ system.matrix(np.imag(rate.A_q) / STEP))[:n_q]
            by_x += factor * s * (w @ np.imag(rate.A_x) / STEP)
    return by_z, by_x


def _state(solution: Solution) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    system = solution.system
    n_q, rest = system.n_q, system.n - system.n_q
    q, acc = np.append(solution.q[-1], np.zeros(rest)), np.append(np.zeros(n_q), solution.multipliers[-1])
    return q, np.zeros_like(q), acc


def plain_terms(solution: Solution, q: np.ndarray, v: np.ndarray, acc: np.ndarray, inputs: Inputs | None = None) -> Terms:
    """Equations of motion with their derivatives, evaluated as plain Python in complex numbers."""
    system, functions = solution.system, plain_formulas_of(solution.system.scene)
    terms, work = allocate_terms(system.plan, complex), allocate_work(system.plan, complex)
    inputs = inputs or system.inputs(solution.times[-1], LEVELS)
    arrays = [np.asarray(each, complex) for each in (q, v, acc)]
    plain(evaluate_all)(system.plan, functions, inputs, *arrays, True, system.n_x > 0, terms, work)
    return of_variables(system.plan, terms)


REPEATED_ROOTS = 1e-6
"""Part of the largest by which two vibrations that are one differ: then neither has a derivative of its own."""


ROOT_UNCERTAINTY = 0.01
"""Part of a slow root by which Rayleigh's quotient moves it at most: the round-off of one of 1e-7 of the fastest is 5e-3 of it, while one
that is round-off goes half the way to zero, or anywhere."""


Idle = Callable[[complex, np.ndarray], bool]


class Vibration(NamedTuple):
    """Root s, right and left vectors u and w (n,), and w^T (2 s M + C) u of a vibration.

    If another root is the same it is not `alone`, and u and w (n_q,) are some of its vectors.
    """

    s: complex
    right: np.ndarray
    left: np.ndarray
    scale: complex
    alone: bool


def find_vibration(
    weights: np.ndarray, pencil: Pencil, number: int, slowness: Callable[[complex], float], idle: Idle | None = None
) -> Vibration:
    """Vibration of a number, counted from 1 in the order of `slowness`, among those whose `slowness` is no nan.

    Parameters
    ----------
    weights : (n_q,)
        What makes coordinates comparable, see `numbering.weights`.
    idle
        Whether a root with its vector (n_q,) is that of a motion that nothing holds, where the state itself leaves it undecided.

    Raises
    ------
    InputError
        There are not so many.
    SingularSystemError
        The joints leave no motion.
    """
    Z, reduced = free_pencil(weights, pencil)
    values, left, right = _without_round_off(reduced, *all_roots(*reduced), _among(Z, idle))
    order = _order(values, slowness)
    if len(order) < number:
        raise InputError(f"there are {len(order)} vibrations about this equilibrium; number = {number} is none of them.")
    k = order[number - 1]
    others = [abs(values[other] - values[k]) for other in order if other != k]
    if values[k] == 0 or min(others, default=np.inf) <= REPEATED_ROOTS * abs(values[k]):
        return Vibration(values[k], Z @ right[:, k], Z @ left[:, k], 0.0, alone=False)
    return _whole(weights, pencil, Z, refined(*reduced, values[k], right[:, k], left[:, k]))


def softest_vibration(weights: np.ndarray, pencil: Pencil) -> Vibration:
    """Vibration with the least squared frequency, of a pencil without damping: far quicker than finding all."""
    Z, reduced = free_pencil(weights, pencil)
    squares, left, right = scipy.linalg.eig(reduced.stiffness, reduced.mass, left=True, right=True)
    order = np.argsort(squares.real)
    k = order[0]
    s = complex(np.sqrt(-squares[k] + 0j))
    if s == 0 or (len(order) > 1 and abs(squares[order[1]] - squares[k]) <= REPEATED_ROOTS * abs(squares[k])):
        return Vibration(s, Z @ right[:, k], Z @ left[:, k], 0.0, alone=False)
    return _whole(weights, pencil, Z, refined(*reduced, s, right[:, k].astype(complex), left[:, k].conj().astype(complex)))


def _whole(weights: np.ndarray, pencil: Pencil, Z: np.ndarray, found: tuple[complex, np.ndarray, np.ndarray]) -> Vibration:
    """Vibration that stands alone, with multipliers, from its vectors in the motions that joints leave free."""
    s, u, w = found[0], Z @ found[1], Z @ found[2]
    whole = s * s * pencil.mass + s * pencil.damping + pencil.stiffness
    J = pencil.stiffness[len(weights) :, : len(weights)]
    u, w = (_with_multipliers(J, each, matrix) for each, matrix in ((u, whole), (w, whole.T)))
    return Vibration(s, u, w, w @ (2 * s * pencil.mass + pencil.damping) @ u, alone=True)


def all_vibrations(
    weights: np.ndarray, pencil: Pencil, slowness: Callable[[complex], float], idle: Idle | None = None
) -> np.ndarray:
    """Roots s of all vibrations that count, in the order of their numbers; `idle` as of `find_vibration`."""
    Z, reduced = free_pencil(weights, pencil)
    values = _without_round_off(reduced, *all_roots(*reduced), _among(Z, idle))[0]
    return values[_order(values, slowness)]


def _without_round_off(
    pencil: Pencil, values: np.ndarray, left: np.ndarray, right: np.ndarray, idle: Idle
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Roots with their vectors; every motion that nothing holds has one root s = 0 in place of its two roots of round-off.

    A slow vibration is known from these by Rayleigh's quotient, which leaves it where it is.
    """
    small = np.flatnonzero([is_zero(s, np.abs(values).max(initial=0)) for s in values])
    zero = [int(k) for k in small if not _stays(pencil, values[k], right[:, k], left[:, k])]
    zero += [k for k in range(len(values)) if k not in zero and idle(complex(values[k]), right[:, k])]
    values[zero] = 0.0
    kept = np.delete(np.arange(len(values)), zero[: len(zero) - len(zero) // 2])
    return values[kept], left[:, kept], right[:, kept]


def _among(Z: np.ndarray, idle: Idle | None) -> Idle:
    """Test `idle` for vectors in the basis Z of the motions that joints leave free."""
    return lambda s, u: idle is not None and idle(s, Z @ u)


def _stays(pencil: Pencil, s: complex, u: np.ndarray, w: np.ndarray) -> bool:
    with np.errstate(all="ignore"):
        found = refined(*pencil, s, u, w)[0]
    return bool(abs(found - s) < ROOT_UNCERTAINTY * abs(s))


def free_pencil(weights: np.ndarray, pencil: Pencil) -> tuple[np.ndarray, Pencil]:
    """Motions that the joints allow, (n_q, n_free), and the pencil reduced to these."""
    n_q = len(weights)
    felt = _felt(pencil, n_q)
    motions = free_motions(pencil.stiffness[n_q:, felt], weights[felt])
    Z = np.zeros((n_q, motions.shape[1]))
    Z[felt] = motions
    if not Z.shape[1]:
        raise SingularSystemError("the joints leave no motion, so nothing vibrates. Remove a joint or a driver.")
    return Z, Pencil(*(Z.T @ each[:n_q, :n_q] @ Z for each in pencil))


def _felt(pencil: Pencil, n_q: int) -> np.ndarray:
    """Numbers of the coordinates that have a mass or affect any other one.

    The state of a load that counts turns makes no vibration.
    """
    alone = np.eye(n_q, dtype=bool)
    stiffness = np.where(alone, 0, pencil.stiffness[:n_q, :n_q]).any(axis=0) | pencil.stiffness[n_q:, :n_q].any(axis=0)
    damping = np.where(alone, 0, pencil.damping[:n_q, :n_q]).any(axis=0)
    return np.flatnonzero(stiffness | damping | pencil.mass[:n_q, :n_q].any(axis=0))


def _order(values: np.ndarray, slowness: Callable[[complex], float]) -> list[int]:
    slow = {k: slowness(complex(value)) for k, value in enumerate(values)}
    return sorted((k for k in slow if np.isfinite(slow[k])), key=lambda k: slow[k])


def _with_multipliers(J: np.ndarray, motion: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Vector [u; mu] with A u + J^T mu = 0 for a motion u (n_q,) that joints allow."""
    n_q = len(motion)
    return np.append(motion, np.linalg.lstsq(J.T, -(matrix[:n_q, :n_q] @ motion))[0])


class Change(NamedTuple):
    """Derivatives of w^T dP u by q, v, a (n_q,), multipliers and the design (n_x,)."""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    multipliers: np.ndarray
    design: np.ndarray


def spinning_pencil(solution: Solution) -> Pencil:
    """Stiffness, damping and mass (n, n) of the state that a solution ends in, square with multipliers."""
    whole = _here(solution).spinning(_motion(solution, solution.q[-1], solution.v[-1]))
    pad = ((0, 0), (0, solution.system.n - solution.system.n_q))
    return Pencil(whole[0], *(np.pad(each, pad) for each in whole[1:]))


def spinning_change(solution: Solution, s: complex, u: np.ndarray, w: np.ndarray) -> Change:
    """Derivatives of w^T dP u with P = s^2 M + s C + K, by q, v, a, multipliers and the design."""
    n_q = solution.system.n_q
    q, v = np.real(solution.q[-1]), np.real(solution.v[-1])
    S = _motion(solution, q, v)
    turned = S @ u[:n_q] + s * u[:n_q]
    direction = (u[:n_q], turned, np.append(S @ turned + s * turned, u[n_q:]))
    found = _along(solution, direction, w)
    here, turns = _here(solution), _by_turning(solution, s, u[:n_q], turned, S)
    by_v, by_a = np.real(here.by_v), np.real(here.by_acc[:, :n_q])
    of_omega = np.array([w @ (by_v @ rate + by_a @ growth) for rate, growth in turns])
    by_q, by_rate = _omega_changes(solution, q, v)
    return found._replace(q=found.q + of_omega @ by_q, v=found.v + of_omega @ by_rate)


def _last_state(solution: Solution) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return solution.q[-1], solution.v[-1], np.concatenate([solution.a[-1], solution.multipliers[-1]])


def _here(solution: Solution) -> Linearised:
    return linearised(solution.system, solution.system.inputs(solution.times[-1], LEVELS), *_last_state(solution))


def _motion(solution: Solution, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    system = solution.system
    return generator(system, angular_velocity(system, q, v), np.zeros(system.scene.dimension)).matrix


def _along(solution: Solution, direction: tuple[np.ndarray, np.ndarray, np.ndarray], w: np.ndarray) -> Change:
    """Derivatives of w^T P u by complex steps along real and imaginary part of a direction of q, v and [a; lam]."""
    system, n_q = solution.system, solution.system.n_q
    pad = np.zeros(system.n - n_q)
    parts = [np.zeros(size, complex) for size in (n_q, n_q, system.n, system.n_x)]
    for part, factor in ((np.real, 1.0), (np.imag, 1j)):
        q, v, acc = (
            np.real(state) + 1j * STEP * part(move) for state, move in zip(_last_state(solution), direction, strict=True)
        )
        terms = of_terms(system, plain_terms(solution, np.append(q, pad), np.append(v, pad), acc))
        for total, each in zip(parts, (terms.by_q, terms.by_v, terms.by_acc, terms.by_x), strict=True):
            total += factor * (w @ np.imag(each) / STEP)
    by_q, by_v, by_acc, by_x = parts
    return Change(by_q, by_v, by_acc[:n_q], by_acc[n_q:], by_x)


def _by_turning(solution: Solution, s: complex, u: np.ndarray, turned: np.ndarray, S: np.ndarray):
    """Derivatives of (S + s) u and (S + s)^2 u by every component of the angular velocity."""
    system = solution.system
    count = 1 if system.scene.space.rotations_add else system.scene.dimension
    for unit in np.eye(count):
        change = generator(system, unit, np.zeros(system.scene.dimension)).matrix
        rate = change @ u
        yield rate, change @ turned + S @ rate + s * rate


def _omega_changes(solution: Solution, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of the mean angular velocity by q and by v, each (1 or 3, n_q), by complex steps."""
    system, unit = solution.system, 1j * STEP * np.eye(len(q))
    by_q = [np.imag(angular_velocity(system, q + each, v + 0j)) / STEP for each in unit]
    by_v = [np.imag(angular_velocity(system, q + 0j, v + each)) / STEP for each in unit]
    return np.array(by_q).T, np.array(by_v).T
