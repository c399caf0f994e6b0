"""Stiffness, damping and mass of small motions about a steady spin, and their derivatives along a vibration.

A vibration u exp(s t) in the frame that spins changes the coordinates by u, velocities by (S + s) u, accelerations by (S + s)^2 u, with
S of `solvers.spin.generator`. Its equations are the residual's derivative along that direction, and mixed derivatives commute.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.responses.vibrations.pencil import STEP, Pencil, plain_terms
from toolkit.solvers.spin.generator import angular_velocity, generator
from toolkit.solvers.spin.state import Linearised, linearised, of_terms
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.system.solution import Solution


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


def _state(solution: Solution) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return solution.q[-1], solution.v[-1], np.concatenate([solution.a[-1], solution.multipliers[-1]])


def _here(solution: Solution) -> Linearised:
    return linearised(solution.system, solution.system.inputs(solution.times[-1], LEVELS), *_state(solution))


def _motion(solution: Solution, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    system = solution.system
    return generator(system, angular_velocity(system, q, v), np.zeros(system.scene.dimension)).matrix


def _along(solution: Solution, direction: tuple[np.ndarray, np.ndarray, np.ndarray], w: np.ndarray) -> Change:
    """Derivatives of w^T P u by complex steps along real and imaginary part of a direction of q, v and [a; lam]."""
    system, n_q = solution.system, solution.system.n_q
    pad = np.zeros(system.n - n_q)
    parts = [np.zeros(size, complex) for size in (n_q, n_q, system.n, system.n_x)]
    for part, factor in ((np.real, 1.0), (np.imag, 1j)):
        q, v, acc = (np.real(state) + 1j * STEP * part(move) for state, move in zip(_state(solution), direction, strict=True))
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
