"""Stiffness and mass of one body under linear constraints, its rigid motions and its constraint modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lu_solve, null_space
from scipy.linalg.lapack import get_lapack_funcs

from toolkit.foundation.errors import InputError
from toolkit.foundation.value_types import Matrix

SINGULAR_CONDITION = 1e-15
"""Reciprocal condition number, after equilibration, of a matrix that cannot be told from a singular one."""

_EQUILIBRATION_STEPS = 5


class SingularBorderedSystemError(ArithmeticError):
    """The constraints leave a motion without stiffness, or repeat each other; callers say it in the words of their input."""


@dataclass(frozen=True, eq=False)
class BorderedSystem:
    """Factors of the matrix [A B^T; B 0], with A (n, n) symmetric and B (m, n).

    Unknowns and rows of very different units (displacements, rotations, forces) are first brought to one size by a diagonal scaling
    on both sides, so that pivoting does not depend on the units; one step of iterative refinement follows every solution.
    Complex symmetric matrices are allowed, for complex steps.
    """

    n: int
    matrix: np.ndarray  # (n + m, n + m), scaled
    scale: np.ndarray  # (n + m,)
    factors: tuple[np.ndarray, np.ndarray]

    def solve(self, above: np.ndarray, below: np.ndarray | float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Solutions u (n, k) and multipliers p (m, k) of A u + B^T p = above, B u = below.

        Parameters
        ----------
        above : (n, k)
        below : (m, k), or one number for all of them
        """
        rows = np.broadcast_to(below, (len(self.scale) - self.n, above.shape[1]))
        right = self.scale[:, None] * np.vstack([above, rows])
        solution = lu_solve(self.factors, right)
        solution = solution + lu_solve(self.factors, right - self.matrix @ solution)
        solution = self.scale[:, None] * solution
        return solution[: self.n], solution[self.n :]


def bordered_system(block: np.ndarray, border: np.ndarray) -> BorderedSystem:
    """Factor [block, border^T; border, 0].

    Parameters
    ----------
    block : (n, n) symmetric
    border : (m, n) of full row rank; m may be zero

    Raises
    ------
    SingularBorderedSystemError
        The bordered matrix is singular to round-off.
    """
    n, m = len(block), len(border)
    matrix = np.block([[block, border.T], [border, np.zeros((m, m))]])
    scale = _equilibration(np.abs(matrix))
    matrix = scale[:, None] * matrix * scale
    return BorderedSystem(n, matrix, scale, _factors(matrix))


def _equilibration(size: np.ndarray) -> np.ndarray:
    """Factors (N,) that bring the largest entry of every row of the symmetric matrix near one.

    D. Ruiz, A scaling algorithm to equilibrate both rows and columns norms in matrices, RAL-TR-2001-034.
    """
    scale = np.ones(len(size))
    for _ in range(_EQUILIBRATION_STEPS):
        largest = (scale[:, None] * size * scale).max(axis=1)
        scale = scale / np.sqrt(np.where(largest > 0, largest, 1.0))
    return scale


def _factors(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    factor, condition = get_lapack_funcs(("getrf", "gecon"), (matrix,))
    lower_upper, pivots, exactly_singular = factor(matrix)
    reciprocal = 0.0 if exactly_singular else condition(lower_upper, np.abs(matrix).sum(axis=0).max())[0]
    if not reciprocal > SINGULAR_CONDITION:
        raise SingularBorderedSystemError(f"the bordered matrix is singular (reciprocal condition number {reciprocal:.0e})")
    return lower_upper, pivots


@dataclass(frozen=True, eq=False)
class ConstrainedPencil:
    """Matrices K, M and R of the problem K u = lambda M u on all u with R u = 0, or their derivatives.

    They are on n nodal coordinates; the derivatives are those by one design variable.

    Derivatives may stay sparse, because they are only multiplied with shapes.
    """

    stiffness: Matrix  # (n, n)
    mass: Matrix  # (n, n)
    rows: np.ndarray  # (n_r, n); n_r may be zero


def constrained_pencil(stiffness: Matrix, mass: Matrix, rows: np.ndarray | None = None) -> ConstrainedPencil:
    """Constrained pencil with dense matrices; without rows the body is free."""
    k, m = _dense(stiffness), _dense(mass)
    return ConstrainedPencil(k, m, np.zeros((0, len(k))) if rows is None else rows)


def _dense(matrix: Matrix) -> np.ndarray:
    return matrix if isinstance(matrix, np.ndarray) else matrix.toarray()


RIGID_EIGENVALUE = 1e-13
"""Largest eigenvalue of a rigid motion, of the stiffness matrix scaled to a unit diagonal: round-off leaves some 1e-16. The first elastic
mode has about (h / L)^2 (t / L)^2 / 12 for elements of length h on a thin skin of length L and thickness t: 1e-7 for 30 elements."""


def rigid_modes(pencil: ConstrainedPencil) -> np.ndarray:
    """Rigid motions T (n, n_rigid), K T = 0, R T = 0, orthonormal in the mass matrix; none of a held body.

    Raises
    ------
    InputError
        The stiffness matrix is that of no body.
    """
    diagonal = np.diag(pencil.stiffness)
    if np.any(diagonal < 0):
        raise InputError(
            f"the stiffness matrix has {np.count_nonzero(diagonal < 0)} negative entries on its diagonal, so that a motion would set "
            "energy free: no body does that. Export it again, or fix its sign."
        )
    scale = 1 / np.sqrt(np.diag(pencil.stiffness).clip(np.finfo(float).tiny))
    held = np.linalg.norm(pencil.rows * scale, axis=1, keepdims=True)
    allowed = null_space(pencil.rows * scale / held) if len(pencil.rows) else np.eye(len(scale))
    try:
        energy, motions = np.linalg.eigh(allowed.T @ (scale[:, None] * pencil.stiffness * scale) @ allowed)
    except np.linalg.LinAlgError as error:
        raise InputError(
            f"the stiffness matrix has no modes ({error}): its entries differ by too many powers of ten. Export it again."
        ) from error
    rigid = scale[:, None] * (allowed @ motions[:, energy < RIGID_EIGENVALUE])
    return _orthonormal(_refined(pencil, rigid), pencil.mass) if rigid.size else rigid


def _refined(pencil: ConstrainedPencil, rigid: np.ndarray) -> np.ndarray:
    """Rigid motions without the strain of the eigenvalue solver's round-off: K u = 0, and M-products as before."""
    border = rigid.T @ pencil.mass
    below = np.vstack([np.zeros((len(pencil.rows), rigid.shape[1])), border @ rigid])
    return bordered_system(pencil.stiffness, np.vstack([pencil.rows, border])).solve(np.zeros_like(rigid), below)[0]


def _orthonormal(shapes: np.ndarray, mass: np.ndarray) -> np.ndarray:
    return np.linalg.solve(np.linalg.cholesky(shapes.T @ mass @ shapes), shapes.T).T


@dataclass(frozen=True, eq=False)
class ConstraintModes:
    """Constraint modes Psi of a boundary R, any linear rows of nodal coordinates, and their reactions Lambda.

        [K R^T; R 0] [Psi; Lambda] = [0; I]

    Column k moves the k-th row of R by one and holds all others. R. R. Craig, M. C. C. Bampton, AIAA J. 6 (1968) 1313, whose
    boundary consists of unit rows.
    """

    shapes: np.ndarray  # (n, n_r)
    reactions: np.ndarray  # (n_r, n_r)
    system: BorderedSystem

    def rates(self, d_pencils: Sequence[ConstrainedPencil]) -> np.ndarray:
        """Derivatives dPsi (n, n_r, n_x) by the design variables whose dK and dR are given; the factors are used again.

        They solve K dPsi + R^T dLambda = -dK Psi - dR^T Lambda and R dPsi = -dR Psi.
        """
        if not d_pencils:
            return np.zeros((*self.shapes.shape, 0))
        above = [d.stiffness @ self.shapes + d.rows.T @ self.reactions for d in d_pencils]
        below = [d.rows @ self.shapes for d in d_pencils]
        rates, _ = self.system.solve(-np.hstack(above), -np.hstack(below))
        return rates.reshape(len(rates), len(d_pencils), -1).swapaxes(1, 2)


def constraint_modes(stiffness: np.ndarray, rows: np.ndarray) -> ConstraintModes:
    """Constraint modes of the boundary `rows`.

    Parameters
    ----------
    stiffness : (n, n)
    rows : (n_r, n), rows of full rank that leave no rigid motion

    Raises
    ------
    InputError
        The rows leave a rigid motion, or are not independent.
    """
    try:
        system = bordered_system(stiffness, rows)
    except SingularBorderedSystemError as error:
        raise InputError(
            f"constraint modes need a boundary that holds the body and whose {len(rows)} rows are independent, but {error}. "
            "Clamp a node, and name every interface point once."
        ) from error
    shapes, reactions = system.solve(np.zeros((len(stiffness), len(rows))), np.eye(len(rows)))
    return ConstraintModes(shapes, reactions, system)
