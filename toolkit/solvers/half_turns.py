"""Refusal of motions that turn a spring or a motor in space by more than half a turn, where its angle would count from the other side."""

from __future__ import annotations

import numpy as np

from toolkit.equations.equations import allocate_work
from toolkit.foundation.errors import ConvergenceError
from toolkit.foundation.kernel import kernel
from toolkit.joints.kernels.laws import angle_of
from toolkit.loads.load import Load
from toolkit.markers.poses import update_poses
from toolkit.system.system import System

HALF_TURN = "its angle in space is one of (-pi, pi], so that its torque would jump. Use smaller angles, or a scene in the plane."


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
        raise ConvergenceError(f"{found[0]} at t = {times[found[1]]:g}: {HALF_TURN}")


def half_turn(system: System, q: np.ndarray) -> tuple[str, int] | None:
    """The first load in space whose angle turns beyond half a turn in states q (n_t, n), in words, and the state after."""
    for name, load in system.scene.loads.items():
        if isinstance(load, Load) and load.folds:
            first, second = (system.numbering.marker((*grip, f"loads.{name}")) for grip in load.grips)
            angles: np.ndarray = np.zeros(len(q), system.dtype)
            work, rest = allocate_work(system.plan, system.dtype), np.zeros_like(q[0])
            system.run(turned_angles, system.plan, first, second, q, rest, work, angles)
            jumps = np.flatnonzero(np.abs(np.diff(np.real(angles))) > np.pi)
            if len(jumps):
                return f"the {load.kind} {name!r} turns beyond half a turn", int(jumps[0]) + 1
    return None
