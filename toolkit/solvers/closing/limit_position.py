"""How far drivers lead a mechanism before no position of its bodies closes the joints any more: its limit position."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from toolkit.equations.equations import Inputs
from toolkit.solvers.closing.nearest import CLOSED, nearest
from toolkit.solvers.closing.rigid_bodies import RigidBodies

SAMPLES, CORRECTIONS = 100, 20
"""Steps of the way at first, and how often coordinates are corrected in one."""
REACH = 0.3
"""Furthest move in a step of the way, a part of the scene's size (or rad): more is a jump to another way of assembling the bodies."""
REPEATED = 1e-10
"""Singular value, in parts of the largest, of joints that repeat each other."""
FINEST = 1e-7
"""Part of the way to which a limit is found."""
BEYOND = 1e-4
"""Part of the way behind a limit where the joints have to stay open, however the bodies are moved."""
Acting = Callable[[float], Inputs]


class Limit(NamedTuple):
    """The last place on the way of the drivers where the joints close, and coordinates (n,) there."""

    place: float
    q: np.ndarray


def limit_position(bodies: RigidBodies, acting: Acting, q: np.ndarray, first: float, last: float) -> Limit | None:
    """Where the way to the last place ends, from a first one near which the bodies are at q (n,); None if it is not known to end."""
    here = closed(bodies, acting(first), q)
    place, step, finest = first, (last - first) / SAMPLES, FINEST * abs(last - first)
    while here is not None and abs(step) > finest and place < last:
        further = min(place + step, last)
        there = closed(bodies, acting(further), here)
        if there is None:
            step /= 2
            continue
        here, place = there, further
        step = min(2 * step, (last - first) / SAMPLES)
    if here is None or place >= last:
        return None
    beyond = min(place + BEYOND * (last - first), last)
    opens = np.abs(nearest(bodies, acting(beyond), here).gaps).max() > 10 * CLOSED
    return Limit(place, here) if opens else None


def closed(bodies: RigidBodies, inputs: Inputs, q: np.ndarray) -> np.ndarray | None:
    """Coordinates next to others that close all joints, by the smallest moves; None if there are none within reach."""
    given, gaps = q, bodies.gaps(inputs, q)
    for _ in range(CORRECTIONS):
        if np.abs(gaps).max() <= CLOSED:
            return q
        move = np.linalg.lstsq(bodies.jacobian(inputs, q), -gaps, rcond=REPEATED)[0]
        q = bodies.moved(q, move)
        if not np.abs(bodies.way(given, q)).max() <= REACH:
            return None
        gaps = bodies.gaps(inputs, q)
    return None
