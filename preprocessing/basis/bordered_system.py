"""Symmetric systems bordered by linear constraints, factored once for any number of right-hand sides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import lu_solve
from scipy.linalg.lapack import get_lapack_funcs

SINGULAR = 1e-15
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
    if not reciprocal > SINGULAR:
        raise SingularBorderedSystemError(f"the bordered matrix is singular (reciprocal condition number {reciprocal:.0e})")
    return lower_upper, pivots
