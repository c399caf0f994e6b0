"""Angles in space that have gone round: an angle about an axis is known up to whole turns only."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from toolkit.foundation.spread import spread
from toolkit.foundation.verdict import Caution
from toolkit.responses.kinematics.relative_angle import RelativeAngle
from toolkit.responses.motion import Rotation
from toolkit.responses.over_time.over_time import OverTime
from toolkit.system.solution import Solution

LOOKED_AT = 500
"""Instants, evenly spread over the motion."""


def folded_rotations(solution: Solution) -> Iterator[Caution]:
    """Caution for every spatial rotation that jumps from one half turn to the other during a motion.

    It is a remark; for means, integrals and extremes over time, which no whole turn can be added to, it is a doubt.
    """
    for name, response in solution.system.scene.responses.items():
        whole = isinstance(response, OverTime)
        looked = response.source if isinstance(response, OverTime) else response
        if isinstance(looked, Rotation) and looked.axis is not None:
            look = looked.instants(solution)
            angles = np.array([float(np.real(look(step).value)) for step in spread(len(solution.times) - 1, LOOKED_AT)])
            if np.any(np.abs(np.diff(angles)) > np.pi):
                what = f"the rotation that {name} is made of" if whole else name
                yield Caution(
                    "rotation-folded",
                    f"{what} passed half a turn: in space it is an angle in (-pi, pi], without the turns that are done. "
                    "The response relative-angle counts them.",
                    doubt=whole,
                )


def folded_equilibria(solution: Solution) -> Iterator[Caution]:
    """Remark for every angle of a spatial equilibrium that passed half a turn on its path: whole turns are not in its value."""
    path = solution.path
    asked = solution.system.scene.responses if path is not None and len(path.q) > 1 else {}
    angles = {f: each for f, each in asked.items() if isinstance(each, Rotation | RelativeAngle) and each.axis is not None}
    if path is None or not angles:
        return
    still = np.zeros_like(path.q)
    along = replace(solution, times=np.arange(len(path.q)), q=path.q, v=still, a=still, multipliers=path.multipliers)
    for name, response in angles.items():
        look = response.instants(along)
        here = float(np.real(response.instants(solution)(0).value))
        turned = np.unwrap([float(np.real(look(step).value)) for step in range(len(path.q))])[-1]
        if abs(turned - here) > np.pi:
            yield Caution(
                "rotation-folded",
                f"{name} = {here:.5g} passed half a turn on the way from the unloaded state: in an equilibrium it is an angle in "
                f"(-pi, pi], without whole turns. With those of the way it is {turned:.5g} rad.",
                doubt=False,
            )
