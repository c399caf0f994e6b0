"""Stiffness, damping and mass of small motions about an equilibrium, and their derivatives along a vibration."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.equations.equations import Inputs, Terms, allocate_terms, allocate_work, evaluate_all, of_variables
from toolkit.foundation.kernel import plain
from toolkit.solvers.static.equilibrium import LEVELS, static_matrix
from toolkit.system.formulas import plain_formulas_of
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
