"""Messages on drivers that lead a mechanism to a limit position, behind which the joints cannot be closed."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from toolkit.equations.equations import Inputs
from toolkit.foundation.units import unit
from toolkit.solvers.closing.nearest import CLOSED, nearest
from toolkit.solvers.closing.rigid_bodies import RigidBodies
from toolkit.system.system import System

SAMPLES, CORRECTIONS = 100, 20
"""Steps of the way at first, and how often coordinates are corrected in one."""
REACH = 0.3
"""Furthest move in a step of the way, a part of the model size (or rad): more is a jump to another way of assembling the bodies."""
REPEATED = 1e-10
"""Singular value, in parts of the largest, of joints that repeat each other."""
FINEST = 1e-7
"""Part of the way to which a limit is found."""
BEYOND = 1e-4
"""Part of the way behind a limit where the joints have to stay open, however the bodies are moved."""
Acting = Callable[[float], Inputs]


class Limit(NamedTuple):
    """Limit position: the last place on the way of the drivers where the joints close, and coordinates (n,) there."""

    place: float
    q: np.ndarray


def limit_position(bodies: RigidBodies, acting: Acting, q: np.ndarray, first: float, last: float) -> Limit | None:
    """Place where the way to the last place ends, from a first one near which the bodies are at q (n,).

    None if it is not known to end.
    """
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


MOVES = 1e-9
"""Change of a driver, in parts of the largest of its values, that is one."""
BACK = (0.0, 1e-4, 1e-2)
"""Parts of the way by which the search begins before a state, which a step may have led a little beyond the limit. From one that is far
off the joints it cannot begin at all, and does so at the start."""
LATE = 0.5
"""Part of the way to a failure at which bodies that bend have to be stopped at least if they did not: otherwise their bending is what the
drivers work on."""


def limit_of_drivers(system: System, acting: Acting, q: np.ndarray, places: tuple[float, float, float]) -> Limit | None:
    """Limit position of the drivers between places (first, here, last), from coordinates (n_q,) or (n,) that bodies have here.

    None if they lead to the last place, or if nothing is known of that.
    """
    bodies, (first, here, last) = RigidBodies(system), places
    if not bodies.countable or not last > here or not _driven(system, acting, here, last):
        return None
    padded, start = np.zeros(system.n), system.start()[0]
    padded[: system.n_q] = np.real(q[: system.n_q])
    before = [max(first, here - back * (last - first)) for back in BACK]
    begins = [(place, padded) for place in before if closed(bodies, acting(place), padded) is not None] or [(first, start)]
    found = limit_position(bodies, acting, begins[0][1], begins[0][0], last)
    if found is None or not bodies.bend:
        return found
    stiff = limit_position(bodies, acting, start, first, last)
    return found if stiff is not None and stiff.place >= first + LATE * (found.place - first) else None


def told_limit(system: System, acting: Acting, limit: Limit, last: float, where: str) -> str:
    """Sentences on a limit position; `where` are the words for its place."""
    said = [_told(system, acting, name, curve, limit.place, last) for name, curve in _driven(system, acting, limit.place, last)]
    rigid = ", whose shapes are kept here," if RigidBodies(system).bend else ""
    return (
        f"the mechanism reaches a limit position {where}: {'; '.join(said)}. Behind it no positions of the bodies{rigid} close all joints. "
        "End the curve before, turn the other way round, or change points or lengths."
    )


def _driven(system: System, acting: Acting, here: float, last: float) -> list[tuple[str, int]]:
    """Joints that follow a curve which goes on from here, and the numbers of these curves."""
    curves = zip(system.scene.joints, system.plan.joints.curve, strict=True)
    ways = [(name, int(c), _way(acting, int(c), here, last)) for name, c in curves if c >= 0]
    return [(name, c) for name, c, way in ways if np.ptp(way) > MOVES * np.abs(way).max()]


def _way(acting: Acting, curve: int, here: float, last: float) -> np.ndarray:
    """Values of a curve from here on, at equally spaced places."""
    return np.array([np.real(acting(place).curves[curve, 0]) for place in np.linspace(here, last, SAMPLES + 1)])


def _told(system: System, acting: Acting, name: str, curve: int, here: float, last: float) -> str:
    way, joint = _way(acting, curve, here, last), system.scene.joints[name]
    label = unit(system.scene.units, joint.rows[-1][1])
    asked = way.max() if way[1] > way[0] else way.min()
    return f"joint {name!r} comes to {way[0]:.3g} {label} and no further, where its curve goes on to {asked:.3g} {label}"
