"""The lowest normal modes of large sparse pencils by shift-invert Lanczos, and their derivatives by a material constant."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_array
from scipy.sparse.linalg import LinearOperator, eigsh

from preprocessing.reduction.constrained_pencil import ConstrainedPencil
from preprocessing.reduction.normal_modes import NormalModes, normal_modes
from preprocessing.reduction.solid_systems import BasisChange
from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import told_apart

DENSE_BELOW = 300
"""Coordinates up to which all modes are computed with dense matrices."""
CONVERGED_RESIDUAL, MOST_ITERATIONS = 1e-11, 500
"""Relative residual and steps of the conjugate gradients for derivatives; the factors' round-off is smaller by some 1e-3."""


class ShiftedSystem(Protocol):
    """Factored stiffness of a body under conditions that hold it."""

    @property
    def stiffness(self) -> csr_array:
        """Stiffness K (n, n)."""

    @property
    def rows(self) -> csr_array:
        """Condition rows B (m, n) of B u = 0."""

    @property
    def writers(self) -> dict[str, str]:
        """Name of the solver that factored the stiffness, and its version."""

    def solve(self, above: np.ndarray, below: np.ndarray | float = 0.0) -> np.ndarray:
        """Displacements u (n, k) under loads (n, k)."""

    def nearly(self, above: np.ndarray) -> np.ndarray:
        """Displacements for B u = 0 without the last digits, for iterations that find these themselves."""

    def following(self, shapes: np.ndarray, change: BasisChange) -> np.ndarray:
        """Displacements (n, k) that keep shapes (n, k) in what holds the body."""

    def loads_of(self, forces: np.ndarray, change: BasisChange) -> np.ndarray:
        """Rates (n, k) of the forces that hold the body, at constant size of these forces."""


def lowest_modes(system: ShiftedSystem, mass: csr_array, enough: Callable[[NormalModes], bool], first: int) -> NormalModes:
    """Lowest modes of K phi = lambda M phi - B^T eta, B phi = 0, as many as are `enough`; more may be found.

    Parameters
    ----------
    mass : (n, n)
    first : number of modes to begin with; it is doubled until there are enough

    Raises
    ------
    InputError
        All modes of a small body, or a third of those of a large one, are not enough; or half of them are wanted to begin with.
    """
    n = mass.shape[0] - system.rows.shape[0]
    if not n:
        return _no_modes(system, mass)
    if mass.shape[0] <= DENSE_BELOW:
        dense = ConstrainedPencil(system.stiffness.toarray(), mass.toarray(), system.rows.toarray())
        return normal_modes(dense)
    count = first
    if first > n // 2:
        raise InputError(f"{first} modes of a body with {n} coordinates are too many. Ask for fewer.")
    while not enough(found := _lanczos(system, mass, count)):
        if count > n // 3:
            raise InputError(f"more than {n // 3} modes of a body with {n} coordinates were asked for. Ask for fewer.")
        count *= 2
    return found


def _no_modes(system: ShiftedSystem, mass: csr_array) -> NormalModes:
    """Empty set of modes, of a body all of whose coordinates are held."""
    none = np.zeros((mass.shape[0], 0))
    pencil = ConstrainedPencil(system.stiffness, mass, system.rows)
    return NormalModes(pencil, np.zeros(0), none, np.zeros((system.rows.shape[0], 0)), np.zeros(0), none)


def _lanczos(system: ShiftedSystem, mass: csr_array, count: int) -> NormalModes:
    n = mass.shape[0]
    inverse = LinearOperator((n, n), matvec=lambda f: system.nearly(f.reshape(-1, 1)).ravel(), dtype=float)
    start = inverse @ (mass @ np.random.default_rng(0).normal(size=n))
    _, found = eigsh(system.stiffness, count, mass, sigma=0.0, OPinv=inverse, v0=start)
    shapes = system.solve(mass @ found)  # once more: round-off along the stiffest modes goes
    values, turn = eigh(shapes.T @ (system.stiffness @ shapes), shapes.T @ (mass @ shapes))
    return _modes(system, mass, values, shapes @ turn)


def _modes(system: ShiftedSystem, mass: csr_array, values: np.ndarray, shapes: np.ndarray) -> NormalModes:
    """Normal modes from eigenvalues and shapes, in order."""
    pencil = ConstrainedPencil(system.stiffness, mass, system.rows)
    columns = told_apart(values, shapes, np.sqrt(mass.diagonal()))
    return NormalModes(pencil, values, shapes, np.zeros((system.rows.shape[0], len(values))), np.zeros(0), columns)


def mode_rates(system: ShiftedSystem, modes: NormalModes, change: BasisChange, beyond: NormalModes) -> np.ndarray:
    """Derivatives (n, m) of the span of the kept modes by a variable; `beyond` are some of those that are left out.

    For every mode j, with v_j that follows the change dB of B phi_j = 0, and on all u with B u = 0 and Phi^T M u = 0,

        (K - lambda_j M) u = -(dK - lambda_j dM) phi_j - dB^T eta_j - (K - lambda_j M) v_j     up to B^T p and M Phi r,   dphi_j = v_j + u

    There the matrix is positive definite, because the kept modes are the lowest ones. So conjugate gradients serve, with K^-1 to speed
    them: the eigenvalues are 1 - lambda_j / lambda_k, k > m. They begin with what the modes beyond the kept ones have of the solution,
    where these eigenvalues are small. See `subspace_rates` for the same with dense factors.
    """
    shapes, pencil = modes.shapes, modes.pencil
    inertia, values = pencil.mass @ shapes, modes.eigenvalues[None]

    def forces(r: np.ndarray) -> np.ndarray:
        return r - inertia @ (shapes.T @ r)

    def nearly(r: np.ndarray) -> np.ndarray:
        u = system.nearly(r)
        return u - shapes @ (inertia.T @ u)

    found = system.following(shapes, change)
    found -= shapes @ (inertia.T @ found)
    loads = -(change.stiffness @ shapes) - system.loads_of(values * inertia - pencil.stiffness @ shapes, change)
    loads -= pencil.stiffness @ found - values * (pencil.mass @ found)
    if change.mass is not None:
        loads += values * (change.mass @ shapes)

    def matrix(u: np.ndarray, columns: np.ndarray) -> np.ndarray:
        return forces(pencil.stiffness @ u - values[:, columns] * (pencil.mass @ u))

    loads = forces(loads)
    along, higher = beyond.shapes.T @ loads, beyond.eigenvalues[:, None]
    begun = beyond.shapes @ (along / (higher - values))
    loads -= matrix(begun, np.arange(modes.count))
    found += begun
    del begun  # a large body's arrays are larger than all else here
    found += _conjugate_gradients(matrix, nearly, loads, (along**2 / higher).sum(axis=0))
    return found


def _conjugate_gradients(matrix: Callable, nearly_inverse: Callable, force: np.ndarray, solved: np.ndarray) -> np.ndarray:
    """Solutions (n, k), column by column but in step, on the space that `nearly_inverse` (n, k) -> (n, k), symmetric, leads into.

    They are as exact as round-off lets the residuals fall. A column whose residual has fallen is left alone from then on.

    Parameters
    ----------
    matrix : (n, j), numbers (j,) of these columns -> (n, j)
    solved : (k,), f^T K^-1 f of the forces f that are carried already
    """
    u, residual, open_ = np.zeros_like(force), force, np.arange(force.shape[1])
    direction = nearly_inverse(residual)
    size = _products(residual, direction)
    enough = CONVERGED_RESIDUAL**2 * (solved + size)
    for _ in range(MOST_ITERATIONS):
        still = size > enough[open_]
        open_, residual, direction, size = open_[still], residual[:, still], direction[:, still], size[still]
        if not len(open_):
            return u
        moved = matrix(direction, open_)
        length = size / _products(direction, moved)
        u[:, open_] += length * direction
        residual = residual - length * moved
        step = nearly_inverse(residual)
        size, before = _products(residual, step), size
        direction = step + size / before * direction
    raise InputError(
        "the derivative of the eigenmodes by poisson_ratio or shape cannot be told: the last mode that is kept and the first that is left "
        'out are too close. Keep one mode more or less, or take the derivative "frozen".'
    )


def _products(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Scalar products of the columns of two arrays, (k,)."""
    return np.einsum("nk,nk->k", one, other)
