"""Whether a scene spins, while an equilibrium and its modes are those at rest."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Caution, check
from toolkit.solvers.start.start_velocities import carried_along, project_velocities, written_velocities
from toolkit.system.solution import Solution
from toolkit.system.system import System

SLOW = 1e-2
"""Spin, as a part of the lowest circular frequency, up to which it is a remark: gyroscopic forces change frequencies by about this part."""
NONE = 1e-9
"""Spin, as a part of the lowest circular frequency, below which it is round-off."""


@check("spins")
def cautions_of_spin(solution: Solution, frequencies: np.ndarray) -> Iterator[Caution]:
    """Frequencies are those about the equilibrium at rest, but the scene spins.

    Limit: any spin; a doubt from 1 % of the lowest circular frequency on.
    Fix: `ffrf modes --spinning`, if a driver spins the scene as a whole; otherwise read the frequencies off a motion.
    """
    found = fastest_spin(solution)
    if found is None:
        return
    body, spin, when = found
    vibrating = 2 * np.pi * np.abs(frequencies[frequencies != 0])
    lowest = float(vibrating.min(initial=np.inf))
    if spin <= NONE * lowest < np.inf:
        return
    beside = f", {spin / lowest:.2g} of the lowest circular frequency" if np.isfinite(lowest) else ""
    yield cautions_of_spin.caution(
        f"these frequencies are those about the equilibrium at rest, but the scene spins: {body!r} with {spin:.4g} rad/s {when}{beside}. "
        f"Gyroscopic and centrifugal forces are not in them. {cautions_of_spin.fix}",
        doubt=not spin <= SLOW * lowest,
    )


def fastest_spin(solution: Solution) -> tuple[str, float, str] | None:
    """Body that turns fastest at the start or, by drivers, at the time of the solution; its rate in rad/time, and when."""
    system = solution.system
    if not written_velocities(system) and not np.any(system.plan.joints.curve >= 0):
        return None
    q, zero = np.concatenate([solution.q[-1], np.zeros(system.n - system.n_q)]), np.zeros(system.n)
    still = np.zeros((system.n, system.n_x))
    time = float(solution.times[-1])
    driven = _velocities(system, q, zero, still, still, time, {})
    candidates = [*_spins(system, *_start(system), "at the start"), *_spins(system, q, driven, f"at t = {time:g}, by its driver")]
    return max(candidates, key=lambda each: each[1], default=None)


def _start(system: System) -> tuple[np.ndarray, np.ndarray]:
    q, v, dq, dv = (np.real(each) for each in system.start())
    v, dv = carried_along(system, q, v, dv, dq)
    return q, _velocities(system, q, v, dq, dv, 0.0, written_velocities(system))


def _velocities(system: System, q, v, dq, dv, time: float, written: dict[int, str]) -> np.ndarray:
    """Velocities that the joints allow; where there are none, those that are given: statics does without."""
    try:
        return np.real(project_velocities(system, q, v, dq, dv, time, written)[0])
    except ToolkitError:
        return v


def _spins(system: System, q: np.ndarray, v: np.ndarray, when: str) -> Iterator[tuple[str, float, str]]:
    for name in system.scene.pieces():
        body, first = system.scene.body(name), system.numbering.first[name]
        at = slice(first, first + body.frame_size)
        rate = body.frame_motion(q[at], v[at]).get("angular_velocity")
        if rate is not None and np.any(rate):
            yield name, float(np.linalg.norm(rate)), when
