"""What the reduced model of a body in few shapes tells of those that its basis leaves out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class LeftOutShapes:
    """Static responses of all shapes that the basis leaves out, to unit loads, at the nominal design.

    With the nodal forces F of the loads, and the modes Phi and eigenvalues Lambda that are left out, which do no work on what is kept,

        C = F^T R F,    B R F,    R = Phi Lambda^-1 Phi^T

    The loads are, of every interface point in the order of their names, forces along the axes and moments about them (in the plane one);
    then what pulls at every mass alike, along each axis; what pulls along axis a as the place along b grows, a before b; and what pulls
    as each shape that is kept moves.
    """

    compliance: np.ndarray  # C (n, n): twice the energy of two loads, and what each moves along the other
    stress_operator: np.ndarray  # B R F (n_stress n_components, n)

    def __len__(self) -> int:
        return len(self.compliance)


def count_of_loads(points: int, dimension: int, n_f: int) -> int:
    """Number of unit loads on a body with so many interface points and elastic shapes."""
    return points * (3 if dimension == 2 else 6) + dimension + dimension**2 + n_f
