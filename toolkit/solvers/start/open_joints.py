"""Messages on joints that do not close, and on drivers that lead a mechanism to a limit position."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby
from typing import NamedTuple

import numpy as np

from toolkit.components.joints.distance import KeptDistance
from toolkit.foundation.units import unit
from toolkit.solvers.start.rigid_bodies import CLOSED_GAP, Nearest, RigidBodies, joint_of, label, nearest, opening
from toolkit.system.equations import Inputs
from toolkit.system.system import System

RESTARTS, MOST_RESTARTED_COORDINATES, RESTART_DISTANCE = 6, 60, 0.7
"""Number of times that the search begins from other positions if it has found none that close; most coordinates for which it
does; distance of these positions."""
NEARLY_EQUAL_GAPS, LARGE_GAP_PART = 0.05, 0.25
"""Part of the largest gap from which a joint may be the one that is told to be open; of two the first one is, if their gaps differ by less
than some such part."""
JOINTS_TRIED, OTHER_GAPS = 6, 1e-5
"""Number of joints that are tried, and the gap, a part of the model size (or rad), of the others that is none then."""
REPEATED_JOINTS = 1e-9
"""Singular value, in parts of the largest, of joints that repeat each other."""


def search(bodies: RigidBodies, inputs: Inputs, q: np.ndarray) -> Nearest | None:
    """Positions that close the joints, or the nearest to that; None where it is not known, or where the given ones (n,) close them."""
    if not bodies.countable or np.abs(bodies.gaps(inputs, q)).max() <= CLOSED_GAP:
        return None
    best = nearest(bodies, inputs, q)
    for n in range(0 if best.closes or len(bodies.frames) > MOST_RESTARTED_COORDINATES else RESTARTS):
        aside = RESTART_DISTANCE * np.sin((n + 1) * (1 + np.arange(len(bodies.frames))))
        other = nearest(bodies, inputs, bodies.moved(q, aside))
        best = other if np.linalg.norm(other.gaps) < (1 - CLOSED_GAP) * np.linalg.norm(best.gaps) else best
        if best.closes:
            break
    return best


def repeat_each_other(bodies: RigidBodies, inputs: Inputs, q: np.ndarray) -> bool:
    """Whether some joints imply others in positions q (n,)."""
    sizes = np.linalg.svd(bodies.jacobian(inputs, q), compute_uv=False)
    return len(sizes) < len(bodies.rows) or bool(sizes[-1] <= REPEATED_JOINTS * sizes[0])


def told_gap(bodies: RigidBodies, inputs: Inputs, found: Nearest) -> str:
    """Sentences on the nearest that joints come to being closed.

    One joint is open and all others are closed, if there is such a joint.
    """
    shapes = ", by bodies that keep their shapes" if bodies.bend else ""
    return (
        f"the joints cannot be closed{shapes}: in the nearest positions that were found, {_what_stays_open(bodies, inputs, found)}. "
        "Give lengths, points or curves that fit together."
    )


def _what_stays_open(bodies: RigidBodies, inputs: Inputs, found: Nearest) -> str:
    candidates = _candidates(bodies, found.gaps)
    for rows in candidates[:JOINTS_TRIED]:
        soft = np.isin(bodies.rows, rows)
        gaps = nearest(bodies, inputs, found.q, soft).gaps
        if np.abs(gaps[~soft]).max(initial=0) <= OTHER_GAPS:
            return f"{_gap_sentence(bodies.system, inputs, rows, gaps[soft] / bodies.system.weights[rows])}, while all others are closed"
    rows = candidates[0]
    gaps = found.gaps[np.isin(bodies.rows, rows)] / bodies.system.weights[rows]
    return f"{_gap_sentence(bodies.system, inputs, rows, gaps)}, and other joints are open too"


def _candidates(bodies: RigidBodies, gaps: np.ndarray) -> list[np.ndarray]:
    """Constraints (k,), by their numbers among all unknowns, of joints that may be the open one.

    Those with a number of their own come first.
    """
    rows, system = bodies.rows, bodies.system
    owners = [joint_of(system, row)[0] for row in rows]
    sizes = {
        name: float(np.linalg.norm(gaps[[owner == name for owner in owners]]))
        for name in dict.fromkeys(owners)
        if name is not None
    }
    kinds: dict[int, list[str]] = {0: [], 1: [], 2: []}
    for name, size in sizes.items():
        if size >= NEARLY_EQUAL_GAPS * max(sizes.values()):
            kinds[_kind(system, name)].append(name)
    for each in kinds.values():
        each.sort(key=lambda name: -round(sizes[name] / max(sizes.values()) / LARGE_GAP_PART))
    return [
        np.array([row for row, owner in zip(rows, owners, strict=True) if owner == name], np.int64)
        for each in kinds.values()
        for name in each
    ]


def _kind(system: System, joint: str) -> int:
    """Rank of a joint among those that may be open: 0 for a driver, 1 for one that keeps a length, 2 for any other."""
    return 0 if _driven(system, joint) >= 0 else 1 if isinstance(system.scene.joints[joint], KeptDistance) else 2


def _driven(system: System, joint: str) -> int:
    """Number of the curve that a joint follows, or -1."""
    return int(system.plan.joints.curve[list(system.scene.joints).index(joint)])


def _gap_sentence(system: System, inputs: Inputs, rows: np.ndarray, gaps: np.ndarray) -> str:
    """Sentence on the gaps in the rows of one joint."""
    name = str(joint_of(system, rows[0])[0])
    which = system.numbering.names[rows[0]] if len(rows) == 1 else f"joint {name!r}"
    sizes = [(label(system, row), opening(system, row, gap)) for row, gap in zip(rows, gaps, strict=True)]
    of_kind = {kind: np.linalg.norm([size for _, size in each]) for kind, each in groupby(sizes, lambda pair: pair[0])}
    said = " and ".join(f"{size:.4g} {kind}" for kind, size in of_kind.items() if size > 0) or "nothing that is seen"
    curve = _driven(system, name)
    if curve < 0:
        return f"{which} is open by {said}"
    asked, (kind, open_by) = float(np.real(inputs.curves[curve, 0])), sizes[-1]
    return f"{which} is open by {said}: it comes to {asked + open_by:.4g} {kind}, where its curve asks for {asked:.4g} {kind}"


SAMPLES, CORRECTIONS = 100, 20
"""Steps of the way at first, and how often coordinates are corrected in one."""
LONGEST_MOVE = 0.3
"""Furthest move in a step of the way, a part of the model size (or rad): more is a jump to another way of assembling the bodies."""
REPEATED = 1e-10
"""Singular value, in parts of the largest, of joints that repeat each other."""
LIMIT_TOLERANCE = 1e-7
"""Part of the way to which a limit is found."""
WAY_BEYOND_LIMIT = 1e-4
"""Part of the way behind a limit where the joints have to stay open, however the bodies are moved."""
Acting = Callable[[float], Inputs]


class LimitPosition(NamedTuple):
    """Limit position: the last place on the way of the drivers where the joints close, and coordinates (n,) there."""

    place: float
    q: np.ndarray


def limit_position(bodies: RigidBodies, acting: Acting, q: np.ndarray, first: float, last: float) -> LimitPosition | None:
    """Place where the way to the last place ends, from a first one near which the bodies are at q (n,).

    None if it is not known to end.
    """
    here = closed(bodies, acting(first), q)
    place, step, finest = first, (last - first) / SAMPLES, LIMIT_TOLERANCE * abs(last - first)
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
    beyond = min(place + WAY_BEYOND_LIMIT * (last - first), last)
    opens = np.abs(nearest(bodies, acting(beyond), here).gaps).max() > 10 * CLOSED_GAP
    return LimitPosition(place, here) if opens else None


def closed(bodies: RigidBodies, inputs: Inputs, q: np.ndarray) -> np.ndarray | None:
    """Coordinates next to others that close all joints, by the smallest moves; None if there are none within reach."""
    given, gaps = q, bodies.gaps(inputs, q)
    for _ in range(CORRECTIONS):
        if np.abs(gaps).max() <= CLOSED_GAP:
            return q
        move = np.linalg.lstsq(bodies.jacobian(inputs, q), -gaps, rcond=REPEATED)[0]
        q = bodies.moved(q, move)
        if not np.abs(bodies.way(given, q)).max() <= LONGEST_MOVE:
            return None
        gaps = bodies.gaps(inputs, q)
    return None


MOVING_DRIVER = 1e-9
"""Change of a driver, in parts of the largest of its values, that is one."""
BACK = (0.0, 1e-4, 1e-2)
"""Parts of the way by which the search begins before a state, which a step may have led a little beyond the limit. From one that is far
off the joints it cannot begin at all, and does so at the start."""
LATE_PART = 0.5
"""Part of the way to a failure at which bodies that bend have to be stopped at least if they did not: otherwise their bending is what the
drivers work on."""


def limit_of_drivers(system: System, acting: Acting, q: np.ndarray, places: tuple[float, float, float]) -> LimitPosition | None:
    """Limit position of the drivers between places (first, here, last), from coordinates (n_q,) or (n,) that bodies have here.

    None if they lead to the last place, or if nothing is known of that.
    """
    bodies, (first, here, last) = RigidBodies(system), places
    if not bodies.countable or not last > here or not _still_driven(system, acting, here, last):
        return None
    padded, start = np.zeros(system.n), system.start()[0]
    padded[: system.n_q] = np.real(q[: system.n_q])
    before = [max(first, here - back * (last - first)) for back in BACK]
    begins = [(place, padded) for place in before if closed(bodies, acting(place), padded) is not None] or [(first, start)]
    found = limit_position(bodies, acting, begins[0][1], begins[0][0], last)
    if found is None or not bodies.bend:
        return found
    stiff = limit_position(bodies, acting, start, first, last)
    return found if stiff is not None and stiff.place >= first + LATE_PART * (found.place - first) else None


def told_limit(system: System, acting: Acting, limit: LimitPosition, last: float, where: str) -> str:
    """Sentences on a limit position; `where` are the words for its place."""
    said = [
        _limit_sentence(system, acting, name, curve, limit.place, last)
        for name, curve in _still_driven(system, acting, limit.place, last)
    ]
    rigid = ", whose shapes are kept here," if RigidBodies(system).bend else ""
    return (
        f"the mechanism reaches a limit position {where}: {'; '.join(said)}. Behind it no positions of the bodies{rigid} close all joints. "
        "End the curve before, turn the other way round, or change points or lengths."
    )


def _still_driven(system: System, acting: Acting, here: float, last: float) -> list[tuple[str, int]]:
    """Joints that follow a curve which goes on from here, and the numbers of these curves."""
    curves = zip(system.scene.joints, system.plan.joints.curve, strict=True)
    ways = [(name, int(c), _way(acting, int(c), here, last)) for name, c in curves if c >= 0]
    return [(name, c) for name, c, way in ways if np.ptp(way) > MOVING_DRIVER * np.abs(way).max()]


def _way(acting: Acting, curve: int, here: float, last: float) -> np.ndarray:
    """Values of a curve from here on, at equally spaced places."""
    return np.array([np.real(acting(place).curves[curve, 0]) for place in np.linspace(here, last, SAMPLES + 1)])


def _limit_sentence(system: System, acting: Acting, name: str, curve: int, here: float, last: float) -> str:
    way, joint = _way(acting, curve, here, last), system.scene.joints[name]
    label = unit(system.scene.units, joint.rows[-1][1])
    asked = way.max() if way[1] > way[0] else way.min()
    return f"joint {name!r} comes to {way[0]:.3g} {label} and no further, where its curve goes on to {asked:.3g} {label}"
