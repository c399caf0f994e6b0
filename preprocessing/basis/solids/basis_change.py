"""What a variable changes on the independent coordinates of a body, for the derivatives of its basis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True, eq=False)
class BasisChange:
    """Derivatives by one variable of what a solid's basis is made of; None is what does not depend on it."""

    stiffness: Any  # dK, sparse (n, n)
    mass: Any = None  # dM, sparse (n, n)
    rows: Any = None  # dB of the averaged interface points, sparse (m, n)
    motions: np.ndarray | None = None  # rate of the rigid motions, (n, m)
    turn: np.ndarray | None = None  # rate of what a chord leaves of the points' motions, see `chord_turn`

    def inside(self, n: int) -> BasisChange:
        """Derivatives on the first n coordinates."""
        if n == self.stiffness.shape[0]:
            return self
        return BasisChange(
            self.stiffness[:n, :n],
            None if self.mass is None else self.mass[:n, :n],
            None if self.rows is None else self.rows[:, :n],
            None if self.motions is None else self.motions[:n],
        )
