"""Refusal of motions that turn a spring or a motor in space by more than half a turn, where its angle would count from the other side.

Of a spring that counts turns, between two states: then nobody knows how many they are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.equations.equations import allocate_work
from toolkit.foundation.errors import ConvergenceError
from toolkit.foundation.kernel import kernel
from toolkit.joints.kernels.laws import angle_of
from toolkit.loads.load import Load
from toolkit.loads.springs import TurnSpring
from toolkit.markers.poses import update_poses
from toolkit.system.system import System

_FOLDED = "its angle in space is one of (-pi, pi], so that its torque would jump. Use smaller angles, or a scene in the plane."
_COUNT = "its angle in space is one of (-pi, pi], so that its torque would jump. Let it count turns: counts_turns = true."
_LOST = "it turned by more than half a turn since the state before, so that its turns cannot be counted. Take smaller steps."


@kernel
def turned_angles(plan, first, second, q, rest, work, out):
    """atan2(e_1a . e_2b, e_1a . e_1b) of two markers at all times, (n_t,)."""
    for n in range(len(q)):
        update_poses(plan.markers.plane, plan.markers.frames, plan.markers, work.markers, q[n], rest, rest, work.scratch)
        a, b, cosine, sine = work.markers.y[first], work.markers.y[second], 0 * q[n, 0], 0 * q[n, 0]
        for i in range(3, 6):
            cosine += a[i] * b[i]
            sine += a[i] * b[i + 3]
        out[n] = angle_of(sine, cosine)


def refuse_half_turns(system: System, times: np.ndarray, q: np.ndarray) -> None:
    """Check all loads that follow an angle in space at states q (n_t, n).

    Raises
    ------
    ConvergenceError
        The angle of one jumps from one side of half a turn to the other; names it and the time.
    """
    found = half_turn(system, q)
    if found:
        raise ConvergenceError(f"{found.what} at t = {times[found.step]:g}: {found.why}")


class HalfTurn(NamedTuple):
    """Which load turns too far, the state after that, and what would be right."""

    what: str
    step: int
    why: str


def half_turn(system: System, q: np.ndarray) -> HalfTurn | None:
    """The first load in space whose angle turns beyond half a turn in states q (n_t, n)."""
    for name, load in system.scene.loads.items():
        if isinstance(load, Load) and load.folds:
            first, second = (system.numbering.marker((*grip, f"loads.{name}")) for grip in load.grips)
            angles: np.ndarray = np.zeros(len(q), system.dtype)
            work, rest = allocate_work(system.plan, system.dtype), np.zeros_like(q[0])
            system.run(turned_angles, system.plan, first, second, q, rest, work, angles)
            counted, why = np.real(angles), _COUNT if isinstance(load, TurnSpring) else _FOLDED
            if isinstance(load, TurnSpring) and load.state is not None:
                turns = (np.real(q[:, system.numbering.first[f"loads.{name}"]]) - counted) / (2 * np.pi)
                counted, why = counted + 2 * np.pi * np.round(turns), _LOST
            jumps = np.flatnonzero(np.abs(np.diff(counted)) > np.pi)
            if len(jumps):
                return HalfTurn(f"the {load.kind} {name!r} turns beyond half a turn", int(jumps[0]) + 1, why)
    return None
