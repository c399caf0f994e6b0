"""The basis Z = [xi, Psi] of a reduced body and its derivatives by the design.

A material point is u_P = S(x_P) Z [1; q_f] in the body frame: xi holds the nodal coordinates that reproduce the undeformed shape,
`S(x) xi = x`, Psi the displacements that belong to the elastic coordinates q_f.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from preprocessing.basis.boundary import Boundary
from preprocessing.basis.constrained_pencil import ConstrainedPencil
from preprocessing.basis.elastic_shapes import ElasticShapes
from preprocessing.basis.normal_modes import NormalModes


@dataclass(frozen=True, eq=False)
class DesignRates:
    """Derivatives by one design variable of everything that a basis is made of."""

    stiffness: Any  # (n, n), sparse or dense
    mass: Any  # (n, n), of M_11 + M_22
    xi: np.ndarray  # (n,), of the undeformed nodal coordinates
    interface_rows: Mapping[str, np.ndarray] = field(
        default_factory=dict
    )  # (3 or 6, n); points that do not change may be left out


@dataclass(frozen=True, eq=False)
class Basis:
    """Matrix Z with the words of the reduced-model file about it; `parts` are the columns of Psi that change with the design."""

    z: np.ndarray  # (n, 1 + n_f)
    reference_condition: str
    description: str  # begins with "frozen:" or "differentiated:"
    frequencies: np.ndarray = field(default_factory=lambda: np.zeros(0))  # of the eigenmodes among the shapes, in Hz
    left_out: Mapping[str, float] = field(default_factory=dict)  # of few shapes, as `ReducedModel.left_out`
    boundary: Boundary | None = None
    beyond: NormalModes | None = None  # modes that are left out
    parts: tuple[ElasticShapes, ...] = ()

    @property
    def constant(self) -> bool:
        """Whether Psi keeps its values at every design that leaves nodes and interface points where they are."""
        return not any(part.follows_matrices for part in self.parts)

    def rate(
        self, d_stiffness: Any, d_mass: Any, d_xi: np.ndarray, d_interface_rows: Mapping[str, np.ndarray] | None = None
    ) -> np.ndarray:
        """Derivative dZ = [dxi, dPsi] (n, 1 + n_f) by one design variable; `rates` is much cheaper for many."""
        return self.rates([DesignRates(d_stiffness, d_mass, d_xi, d_interface_rows or {})])[:, :, 0]

    def rates(self, changes: Sequence[DesignRates]) -> np.ndarray:
        """Derivatives dZ (n, 1 + n_f, n_x) by all design variables, each matrix factored once; dPsi is zero for a frozen basis.

        Some arrays of the result's size are needed on the way: give thousands of variables in portions.

        Raises
        ------
        InputError
            An interface point leaves the clamped node.
        """
        rates = np.zeros((*self.z.shape, len(changes)))
        if not changes:
            return rates
        rates[:, 0] = np.column_stack([change.xi for change in changes])
        if self.parts and self.boundary is not None:
            d_pencils = [
                ConstrainedPencil(change.stiffness, change.mass, self.boundary.rates(change.interface_rows, change.xi))
                for change in changes
            ]
            rates[:, 1:] = np.concatenate([part.rates(d_pencils) for part in self.parts], axis=1)
            rates[self.boundary.always_still, 1:] = 0
        return rates
