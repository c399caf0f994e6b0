"""Constraint modes: the shapes of least strain energy for unit displacements of a boundary, and their derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from preprocessing.basis.bordered_system import BorderedSystem, SingularBorderedSystemError, bordered_system
from preprocessing.basis.constrained_pencil import ConstrainedPencil
from toolkit.foundation.errors import InputError


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
