"""Rotations in space that have gone round: an angle about an axis is known up to whole turns only."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.spread import spread
from toolkit.foundation.verdict import Caution
from toolkit.responses.motion import Rotation
from toolkit.system.solution import Solution

LOOKED_AT = 500
"""Instants, evenly spread over the motion."""


def folded_rotations(solution: Solution) -> Iterator[Caution]:
    """A remark for every rotation of a scene in space that jumps from one half turn to the other on the way."""
    for name, response in solution.system.scene.responses.items():
        if isinstance(response, Rotation) and response.axis is not None:
            look = response.instants(solution)
            angles = np.array([float(np.real(look(step).value)) for step in spread(len(solution.times) - 1, LOOKED_AT)])
            if np.any(np.abs(np.diff(angles)) > np.pi):
                yield Caution(
                    "rotation-folded",
                    f"{name} passed half a turn: in space it is an angle in (-pi, pi], without the turns that are done. "
                    "The response relative-angle counts them.",
                    doubt=False,
                )
