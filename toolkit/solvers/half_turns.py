"""Refusal of motions in which a spring or a motor in space loses the turn of its angle, so that its torque would jump."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toolkit.components.joints.kernels.laws import angle_of
from toolkit.components.loads.load import Load
from toolkit.components.markers.poses import update_poses
from toolkit.foundation.errors import ConvergenceError
from toolkit.foundation.kernel import kernel
from toolkit.system.equations import allocate_work
from toolkit.system.quantities import named_loads
from toolkit.system.system import System

LOST = {
    "zero": (
        "turns beyond half a turn",
        "its angle in space is one of (-pi, pi], so that its torque would jump. Let it count turns (counts_turns = true), or use "
        "smaller angles.",
    ),
    "state": (
        "turns by more than half a turn between two states",
        "its turns cannot be counted, and its torque would jump. Use smaller steps, or more load steps.",
    ),
    "curve": ("stays half a turn behind", "its torque would jump. Let it follow its curve more closely, or use smaller steps."),
}
"""Messages by the reference next to which a load takes the turn of its angle: what happened, and what to do."""


@kernel
def turned_angles(plan, first, second, q, rest, work, out):
    """atan2(e_1a . e_2b, e_1a . e_1b) of two markers at all times, (n_t,)."""
    for n in range(len(q)):
        markers = plan.markers
        update_poses(markers.plane, markers.frames, markers, work.markers, q[n], rest, rest, False, work.scratch)
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
    found = half_turn(system, q, lambda: system.curve_values(times))
    if found:
        raise ConvergenceError(f"{found[0]} at t = {times[found[2]]:g}: {found[1]}")


def half_turn(system: System, q: np.ndarray, curves: Callable[[], np.ndarray]) -> tuple[str, str, int] | None:
    """First load in space whose angle loses its turn in states q (n_t, n), in words, with the remedy and the state after.

    `curves` finds the values (n_t, n_curves, ...) of all time curves there.
    """
    for k, (name, load) in enumerate(named_loads(system.scene).items()):
        if load.turn is not None:
            seen = _seen(system, k, load, _angles(system, name, load, q), q, curves)
            jumps = np.flatnonzero(np.abs(np.diff(seen)) > np.pi)
            if len(jumps):
                happened, remedy = LOST[load.turn]
                return f"the {load.kind} {name!r} {happened}", remedy, int(jumps[0]) + 1
    return None


def _seen(system: System, k: int, load: Load, angles: np.ndarray, q: np.ndarray, curves: Callable[[], np.ndarray]) -> np.ndarray:
    """Angles as load number k sees them: with the turns that it counts, from its set value, or as they are."""
    if load.turn == "state":
        turns = (np.real(q[:, system.plan.loads.state[k]]) - angles) / (2 * np.pi)
        return angles + 2 * np.pi * np.round(turns)
    if load.turn == "curve":
        from_set_value = angles - np.real(curves()[:, system.plan.loads.curve[k], 0])
        return (from_set_value + np.pi) % (2 * np.pi)
    return angles


def _angles(system: System, name: str, load: Load, q: np.ndarray) -> np.ndarray:
    """Angle of a load in states q, (n_t,), in (-pi, pi]."""
    first, second = (system.numbering.marker((*grip, f"loads.{name}")) for grip in load.grips)
    angles: np.ndarray = np.zeros(len(q), system.dtype)
    work, rest = allocate_work(system.plan, system.dtype), np.zeros_like(q[0])
    system.run(turned_angles, system.plan, first, second, q, rest, work, angles)
    return np.real(angles)
