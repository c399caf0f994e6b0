"""Whether a bushing in space is turned further than its small rotations mean."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.near_ties import spread
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.loads.bushing import SpatialBushing
from toolkit.system.marker_states import poses_at
from toolkit.system.solution import Solution

SMALL = np.radians(30)
"""Angle at which its sine, which the torque grows with, is off by 4.5 %."""
LOOKED_AT = 500
"""So many instants are looked at."""


@check("bushing-turned-far", STATES)
def bushings_turned_far(solution: Solution) -> Iterator[Caution]:
    """A bushing in space is turned by more than a small rotation, for which its torques are defined.

    Limit: 30 degrees, where they are off by 4.5 %.
    Fix: a universal or revolute joint with rotational springs.
    """
    system = solution.system
    bushings = {name: load for name, load in system.scene.loads.items() if isinstance(load, SpatialBushing)}
    bushings = {name: load for name, load in bushings.items() if any((*load.rotational_stiffness, *load.rotational_damping))}
    if not bushings:
        return
    states = np.atleast_2d(np.real(solution.q))
    poses = poses_at(system, states[spread(len(states) - 1, LOOKED_AT)])
    for name, load in bushings.items():
        first, second = (system.numbering.marker(grip) for grip in load.grips)
        cosine = (np.einsum("tk,tk->t", poses[:, first, 3:], poses[:, second, 3:]) - 1) / 2
        largest = float(np.arccos(np.clip(cosine.min(), -1, 1)))
        if largest > SMALL:
            yield bushings_turned_far.caution(
                f"loads.{name} turns by up to {np.degrees(largest):.0f} degrees. A bushing in space has the torques of a small rotation: "
                f"at 30 degrees its stiffness acts 4.5 % too little, its damping 25 %. {bushings_turned_far.fix}",
            )
