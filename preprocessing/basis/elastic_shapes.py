"""The columns Psi of a basis as parts that know their own derivatives: constraint modes and eigenmodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from preprocessing.basis.constrained_pencil import ConstrainedPencil
from preprocessing.basis.constraint_modes import ConstraintModes
from preprocessing.basis.normal_modes import NormalModes
from preprocessing.basis.subspace_rates import subspace_rates


class ElasticShapes(Protocol):
    """Part of the columns of Psi, with its derivatives."""

    @property
    def follows_matrices(self) -> bool:
        """Whether the shapes change with stiffness and mass, or with the places of nodes and points alone."""

    @property
    def columns(self) -> np.ndarray:
        """Shapes on the nodal coordinates, (n, k)."""

    def rates(self, d_pencils: Sequence[ConstrainedPencil]) -> np.ndarray:
        """Derivatives (n, k, n_x) of the shapes by the design variables whose dK, dM and dR are given."""


@dataclass(frozen=True, eq=False)
class InterfaceShapes:
    """Constraint modes of the interface points; those that hold the body, the first `n_clamp`, are zero."""

    modes: ConstraintModes
    n_clamp: int
    follows_matrices: ClassVar[bool] = True

    @property
    def columns(self) -> np.ndarray:
        """Shapes on the nodal coordinates, (n, n_r - n_clamp)."""
        return self.modes.shapes[:, self.n_clamp :]

    def rates(self, d_pencils: Sequence[ConstrainedPencil]) -> np.ndarray:
        """Derivatives of the shapes by the design variables, (n, n_r - n_clamp, n_x)."""
        return self.modes.rates(d_pencils)[:, self.n_clamp :]


@dataclass(frozen=True, eq=False)
class ModeShapes:
    """Eigenmodes, which change within the derivative of their span."""

    modes: NormalModes
    follows_matrices: ClassVar[bool] = True

    @property
    def columns(self) -> np.ndarray:
        """Shapes on the nodal coordinates, (n, m)."""
        return self.modes.columns

    def rates(self, d_pencils: Sequence[ConstrainedPencil]) -> np.ndarray:
        """Derivatives of the shapes by the design variables, (n, m, n_x)."""
        return self.modes.turned(subspace_rates(self.modes, d_pencils))
