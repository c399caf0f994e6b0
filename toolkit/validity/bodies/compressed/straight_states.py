"""Whether what the equations lack of a compressed body is felt in an equilibrium at all.

They lack the forces G q of the geometric stiffness G in elastic coordinates q, and of a derivative G dq/dx: a deflection K^-1 G q. A column
that nothing bends, and that does not buckle, is as it should be with any force along it: G knows lateral motions alone, and q has none.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from toolkit.system.flexible_bodies import elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.compressed.geometric_stiffness import Stiffening

ROUND_OFF = 1e-6
"""Part of the largest of q, in units of the scene's size, below which the deflection K^-1 G q is that of round-off: forces along a hinged
bar bend it by 4e-11 of what they shorten it with 20 elements, by 7e-8 with 300. What is there still is as small, and ten times that
at 0.9 of the critical load."""


def stays_straight(solution: Solution, known: Mapping[str, Stiffening]) -> bool:
    """Whether no body feels in an equilibrium, nor in the derivatives that it was solved with, what the equations lack of its stiffness."""
    if solution.steps or solution.spins:
        return False
    for body, law in known.items():
        where = elastic_coordinates(solution, body)
        weights, elastic = solution.system.weights[where], np.real(solution.q[0, where])
        moved = np.column_stack([elastic, np.real(solution.dq[0, where])])
        felt, size = (np.abs(weights[:, None] * each).max(axis=0) for each in (law.deflections(elastic, moved), moved))
        if not np.all(felt <= ROUND_OFF * size):
            return False
    return True
