"""Whether a spring passes length zero: its force points along it, and jumps to the other side there."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.near_ties import spread
from toolkit.foundation.verdict import MOTION, Caution, check
from toolkit.loads.controllers import DistanceControlled
from toolkit.loads.springs import PointSpring
from toolkit.system.marker_states import poses_at
from toolkit.system.solution import Solution

LOOKED_AT = 500
"""Number of instants that are compared with the next; between two that point against each other every step is."""


@check("spring-through-zero", (MOTION,))
def springs_through_zero(solution: Solution) -> Iterator[Caution]:
    """A spring passes length zero, where its force jumps to the other side.

    Limit: any.
    Fix: one end aside, a relaxed length of zero, or a force without a jump.

    Its force jumps by 2 k l_0 there. Values follow the jump to first order in the step; derivatives hold it at its time, and miss how the
    design moves it.
    """
    scene, last = solution.system.scene, len(solution.times) - 1
    springs = {
        name: load
        for name, load in scene.loads.items()
        if isinstance(load, DistanceControlled)
        or (isinstance(load, PointSpring) and load.stiffness and np.real(load.parameters(scene)[2]) > 0)
    }
    if not springs:
        return
    some = np.array(spread(last, LOOKED_AT))
    for (name, spring), turns in zip(springs.items(), _turns(solution, list(springs.values()), some), strict=True):
        closer = (np.arange(some[at], some[at + 1] + 1) for at in turns)
        found = next((int(every[at[0]]) for every in closer if len(at := _turns(solution, [spring], every)[0])), None)
        if found is not None:
            yield springs_through_zero.caution(
                f"loads.{name} passes length zero at t = {solution.times[found]:.6g}. Its force, which points along it, jumps to the other "
                "side there. Values follow the jump to first order in the step; derivatives miss how the design moves it. "
                f"{springs_through_zero.fix}",
            )


def _turns(solution: Solution, springs: list[PointSpring | DistanceControlled], steps: np.ndarray) -> list[np.ndarray]:
    """Places in `steps`, for each spring, after which the vector from end to end points against the one before."""
    system = solution.system
    ends = np.array([[system.numbering.marker(grip) for grip in each.grips] for each in springs])
    poses = poses_at(system, solution.q[steps])[:, :, : system.scene.dimension]
    vectors = poses[:, ends[:, 0]] - poses[:, ends[:, 1]]
    against = np.einsum("tsi,tsi->ts", vectors[:-1], vectors[1:]) < 0
    return [np.flatnonzero(each) for each in against.T]
