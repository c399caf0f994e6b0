"""Whether what the equations lack of a compressed body is felt in an equilibrium at all.

They lack the forces G q of the geometric stiffness G in elastic coordinates q, and of a derivative G dq/dx. A column that nothing bends,
and that does not buckle, is as it should be with any force along it: G knows lateral motions alone, and q has none.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from toolkit.solvers.static.stability.static_array import largest_entry, scaled_by
from toolkit.system.flexible_bodies import elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.compressed.geometric_stiffness import Stiffening

ROUND_OFF = 1e-8
"""Part of the largest entry of G times the largest of q, in units of the scene's size, below which G q is that of round-off: forces along
a bar of L / h = 100 bend it by 1e-11 of what they shorten it. What is there still may be larger a thousandfold near the critical load, and
is then 1e-5 of the displacement."""


def stays_straight(solution: Solution, known: Mapping[str, Stiffening]) -> bool:
    """Whether no body feels in an equilibrium, nor in the derivatives that it was solved with, what the equations lack of its stiffness."""
    if solution.steps or solution.spins:
        return False
    for body, law in known.items():
        where = elastic_coordinates(solution, body)
        weights, elastic = solution.system.weights[where], np.real(solution.q[0, where])
        geometric = scaled_by(law.matrix(elastic), 1 / weights)
        moved = weights[:, None] * np.column_stack([elastic, np.real(solution.dq[0, where])])
        felt = np.abs(geometric @ moved).max(axis=0)
        if not np.all(felt <= ROUND_OFF * largest_entry(geometric) * np.abs(moved).max(axis=0)):
            return False
    return True
