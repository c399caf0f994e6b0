"""Frequencies and damping of the vibrations about an equilibrium.

With the static residual's derivative K (by q and lam), the mass M and the damping C, the latter two without multipliers, a vibration is

    (s^2 M + s C + K) u = 0,     w^T (s^2 M + s C + K) = 0
    ds = - w^T (s^2 dM + s dC + dK) u / w^T (2 s M + C) u

Mixed derivatives commute: w^T dK/dz_j u is what K changes by along u, transposed, times w; one complex step along u gives it exactly, for
all z_j and the design at once, and one of the velocities along u does the same for C.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, NamedTuple

import numpy as np
from pydantic import Field
from scipy.linalg import eig

from toolkit.equations.equations import Terms, allocate_terms, allocate_work, evaluate_all
from toolkit.foundation.errors import InputError, SingularSystemError
from toolkit.foundation.kernel import plain
from toolkit.responses.response import Partials, Response
from toolkit.solvers.free_motions import free_motions
from toolkit.solvers.static.equilibrium import LEVELS, static_matrix
from toolkit.system.solution import Solution
from toolkit.system.system import System, plain_formulas_of

STEP = 1e-30
"""Complex step: far below round-off."""
SAME = 1e-6
"""Part of the largest by which two vibrations that are one differ: then neither has a derivative of its own."""


BESIDE = 1e-19
"""Part of its largest entry that keeps a matrix with an exact root solvable; no digit of the vectors feels it."""
REFINED = 2
"""Steps of Rayleigh's quotient, whose error falls to its third power."""


class Pencil(NamedTuple):
    """K (n, n) of coordinates and multipliers, C and M (n, n), zero but for the coordinates; real or complex."""

    stiffness: np.ndarray
    damping: np.ndarray
    mass: np.ndarray


class Vibration(NamedTuple):
    """s, its right and left vectors u and w (n,), and w^T (2 s M + C) u; if another has the same s it is not `alone`, and s is all."""

    s: complex
    right: np.ndarray
    left: np.ndarray
    scale: complex
    alone: bool


class OfVibration(Response):
    """Base of responses of one vibration about an equilibrium.

    Attributes
    ----------
    number
        Which one, from the slowest on.
    """

    number: int = Field(default=1, ge=1, strict=True)

    @property
    def needs_rest(self) -> bool:
        """Always: vibrations about a motion are no modes of it."""
        return True

    @abstractmethod
    def counted(self, damping: np.ndarray) -> np.ndarray:
        """The damping (n, n) that counts."""

    @abstractmethod
    def of(self, s: complex) -> float:
        """The number from s; nan where s is no vibration that counts."""

    def slowness(self, s: complex) -> float:
        """What vibrations are numbered by."""
        return float(abs(s))

    @abstractmethod
    def slope(self, s: complex, ds: Any) -> Any:
        """Its change with that of s, (...,) complex, real."""

    def partials(self, solution: Solution) -> Partials:
        """Of the vibration of that number.

        Raises
        ------
        InputError
            There are not so many.
        SingularSystemError
            The joints leave no motion.
        """
        system, pencil = solution.system, _pencil(solution)
        real = Pencil(*(np.real(each) for each in pencil))
        found = self._vibration(system, real._replace(damping=self.counted(real.damping)))
        s, u, w = found.s, found.right, found.left
        if not found.alone:  # which of both it is nobody knows
            lost = self.of(s) if system.compiled else complex(self.of(s), np.nan)
            return Partials(lost, design=np.full(system.n_x, np.nan))
        step = Pencil(*(np.imag(each) for each in pencil))
        moved = s * s * step.mass + s * self.counted(step.damping) + step.stiffness
        value = self.of(s) + 1j * self.slope(s, -(w @ moved @ u) / found.scale)
        changes = _change(solution, found, damped=bool(np.any(self.counted(np.ones((1, 1))))))
        by_z, design = (self.slope(s, -each / found.scale) for each in changes)
        n_q = system.n_q
        return Partials(value.real if system.compiled else value, q=by_z[None, :n_q], multipliers=by_z[None, n_q:], design=design)

    def _vibration(self, system: System, pencil: Pencil) -> Vibration:
        n_q = system.n_q
        J = pencil.stiffness[n_q:, :n_q]
        Z = free_motions(J, system.weights[:n_q])
        if not Z.shape[1]:
            raise SingularSystemError("the joints leave no motion, so nothing vibrates. Remove a joint or a driver.")
        reduced = Pencil(*(Z.T @ each[:n_q, :n_q] @ Z for each in pencil))
        values, left, right = _roots(reduced)
        known = [k for k in range(len(values)) if np.isfinite(self.of(values[k]))]
        order = sorted(known, key=lambda k: self.slowness(complex(values[k])))
        if len(order) < self.number:
            raise InputError(f"there are {len(order)} vibrations about this equilibrium; number = {self.number} is none of them.")
        k = order[self.number - 1]
        others = [abs(values[other] - values[k]) for other in order if other != k]
        if min(others, default=np.inf) <= SAME * abs(values[k]):
            return Vibration(values[k], right[:, k], left[:, k], 0.0, alone=False)
        s, u, w = _refined(reduced, values[k], right[:, k], left[:, k])
        u, w = Z @ u, Z @ w
        whole = s * s * pencil.mass + s * pencil.damping + pencil.stiffness
        u, w = (_with_multipliers(J, each, matrix) for each, matrix in ((u, whole), (w, whole.T)))
        return Vibration(s, u, w, w @ (2 * s * pencil.mass + pencil.damping) @ u, alone=True)


class Frequency(OfVibration):
    """Frequency of an undamped vibration about an equilibrium, in cycles per time: those of `ffrf modes`. Negative where the equilibrium is
    unstable.
    """

    kind = "frequency"
    quantity = "rate"

    def counted(self, damping: np.ndarray) -> np.ndarray:
        """None."""
        return 0 * damping

    def of(self, s: complex) -> float:
        """Im s of a pair of roots, - Re s where it is real; one of each pair."""
        vibrates = abs(s.imag) >= abs(s.real)
        one = s.imag if vibrates else s.real
        return (one if vibrates else -one) / (2 * np.pi) if one >= 0 else np.nan

    def slowness(self, s: complex) -> float:
        """The frequency, so that what is unstable comes first."""
        return self.of(s)

    def slope(self, s: complex, ds: Any) -> Any:
        """Of the same."""
        return (np.imag(ds) if abs(s.imag) >= abs(s.real) else -np.real(ds)) / (2 * np.pi)


class DampingRatio(OfVibration):
    """Damping of a vibration about an equilibrium, in parts of the critical one: - Re s / |s|. What is damped more than critically does not
    vibrate and is not counted.
    """

    kind = "damping-ratio"
    quantity = "none"

    def counted(self, damping: np.ndarray) -> np.ndarray:
        """All of it."""
        return damping

    def of(self, s: complex) -> float:
        """- Re s / |s| of one of each pair."""
        return -s.real / abs(s) if s.imag > SAME * abs(s) else np.nan

    def slope(self, s: complex, ds: Any) -> Any:
        """Of the same."""
        return -np.real(ds) / abs(s) + s.real * np.real(np.conj(s) * ds) / abs(s) ** 3


def _roots(pencil: Pencil) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All s, and their left and right vectors as columns, in units of time in which stiffness and mass are alike."""
    K, C, M = pencil
    unit = np.sqrt(np.abs(K).max() / np.abs(M).max())
    one, none = np.eye(len(K)), np.zeros(K.shape)
    first = np.block([[none, one], [-K / unit**2, -C / unit]])
    values, left, right = eig(first, np.block([[one, none], [none, M]]), left=True, right=True)
    return unit * values, left[len(K) :].conj(), right[: len(K)]


def _refined(pencil: Pencil, s: complex, u: np.ndarray, w: np.ndarray) -> tuple[complex, np.ndarray, np.ndarray]:
    """s and its vectors by Rayleigh's quotient, down to the round-off of the matrices themselves."""
    K, C, M = pencil
    for _ in range(REFINED):
        s = s - (w @ (s * s * M + s * C + K) @ u) / (w @ (2 * s * M + C) @ u)
        matrix = s * s * M + s * C + K
        matrix = matrix + BESIDE * np.abs(K).max() * np.eye(len(K))
        u, w = np.linalg.solve(matrix, M @ u), np.linalg.solve(matrix.T, M.T @ w)
        u, w = u / np.abs(u).max(), w / np.abs(w).max()
    return s, u, w


def _with_multipliers(J: np.ndarray, motion: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """[u; mu] with A u + J^T mu = 0 for a motion u (n_q,) that joints allow."""
    n_q = len(motion)
    return np.append(motion, np.linalg.lstsq(J.T, -(matrix[:n_q, :n_q] @ motion))[0])


def _state(solution: Solution) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    system = solution.system
    n_q, rest = system.n_q, system.n - system.n_q
    q, acc = np.append(solution.q[-1], np.zeros(rest)), np.append(np.zeros(n_q), solution.multipliers[-1])
    return q, np.zeros_like(q), acc


def _pencil(solution: Solution) -> Pencil:
    system, n_q = solution.system, solution.system.n_q
    terms = system.evaluate(system.inputs(solution.times[-1], LEVELS), *_state(solution))
    stiffness, damping, mass = (system.matrix(each).toarray() for each in (static_matrix(system, terms), terms.A_v, terms.I_acc))
    for each in (damping, mass):
        each[n_q:], each[:, n_q:] = 0, 0
    return Pencil(stiffness, damping, mass)


def _change(solution: Solution, found: Vibration, damped: bool) -> tuple[np.ndarray, np.ndarray]:
    """w^T (s^2 dM + s dC + dK) u by q and multipliers (n,), and by the design (n_x,)."""
    system, n_q, (s, u, w) = solution.system, solution.system.n_q, found[:3]
    q, v, acc = (np.real(each) for each in _state(solution))
    by_z, by_x = np.zeros(system.n, complex), np.zeros(system.n_x, complex)
    of_q = np.arange(system.n) < n_q
    for part, factor in ((np.real(u), 1.0), (np.imag(u), 1j)):
        motion, force = np.where(of_q, part, 0), np.where(of_q, 0, part)
        along = _plain_terms(solution, q + 1j * STEP * motion, v, acc + 1j * STEP * force)
        by_z += factor * (w @ system.matrix(np.imag(static_matrix(system, along)) / STEP))
        by_x += factor * (w @ np.imag(along.I_x + along.A_x) / STEP)
        moving = _plain_terms(solution, q, v, motion)
        by_z[:n_q] += factor * s * s * (w @ system.matrix(np.real(moving.I_q)))[:n_q]
        by_x += factor * s * s * (w[:n_q] @ np.real(moving.I_x)[:n_q])
        if damped:
            rate = _plain_terms(solution, q, v + 1j * STEP * motion, acc)
            by_z[:n_q] += factor * s * (w @ system.matrix(np.imag(rate.A_q) / STEP))[:n_q]
            by_x += factor * s * (w @ np.imag(rate.A_x) / STEP)
    return by_z, by_x


def _plain_terms(solution: Solution, q: np.ndarray, v: np.ndarray, acc: np.ndarray) -> Terms:
    """The equations with their derivatives as plain Python, in complex numbers."""
    system, functions = solution.system, plain_formulas_of(solution.system.scene)
    terms, work = allocate_terms(system.plan, complex), allocate_work(system.plan, complex)
    inputs = system.inputs(solution.times[-1], LEVELS)
    arrays = [np.asarray(each, complex) for each in (q, v, acc)]
    plain(evaluate_all)(system.plan, functions, inputs, *arrays, True, system.n_x > 0, terms, work)
    return terms
