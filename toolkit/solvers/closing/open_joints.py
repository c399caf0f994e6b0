"""Messages on joints that do not close: how near they come, and which one stays open by how much."""

from __future__ import annotations

from itertools import groupby

import numpy as np

from toolkit.equations.equations import Inputs
from toolkit.joints.distance import KeptDistance
from toolkit.solvers.closing.nearest import CLOSED, Nearest, nearest
from toolkit.solvers.closing.openings import joint_of, label, opening
from toolkit.solvers.closing.rigid_bodies import RigidBodies
from toolkit.system.system import System

AGAIN, FEW, ASIDE = 6, 60, 0.7
"""Number of times that the search begins from other positions if it has found none that close; most coordinates for which it
does; distance of these positions."""
TAKES_PART, LARGE = 0.05, 0.25
"""Part of the largest gap from which a joint may be the one that is told to be open; of two the first one is, if their gaps differ by less
than some such part."""
TRIED, OTHERS = 6, 1e-5
"""Number of joints that are tried, and the gap, a part of the model size (or rad), of the others that is none then."""
REPEATED = 1e-9
"""Singular value, in parts of the largest, of joints that repeat each other."""


def search(bodies: RigidBodies, inputs: Inputs, q: np.ndarray) -> Nearest | None:
    """Positions that close the joints, or the nearest to that; None where it is not known, or where the given ones (n,) close them."""
    if not bodies.countable or np.abs(bodies.gaps(inputs, q)).max() <= CLOSED:
        return None
    best = nearest(bodies, inputs, q)
    for n in range(0 if best.closes or len(bodies.frames) > FEW else AGAIN):
        aside = ASIDE * np.sin((n + 1) * (1 + np.arange(len(bodies.frames))))
        other = nearest(bodies, inputs, bodies.moved(q, aside))
        best = other if np.linalg.norm(other.gaps) < (1 - CLOSED) * np.linalg.norm(best.gaps) else best
        if best.closes:
            break
    return best


def repeat_each_other(bodies: RigidBodies, inputs: Inputs, q: np.ndarray) -> bool:
    """Whether some joints imply others in positions q (n,)."""
    sizes = np.linalg.svd(bodies.jacobian(inputs, q), compute_uv=False)
    return len(sizes) < len(bodies.rows) or bool(sizes[-1] <= REPEATED * sizes[0])


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
    for rows in candidates[:TRIED]:
        soft = np.isin(bodies.rows, rows)
        gaps = nearest(bodies, inputs, found.q, soft).gaps
        if np.abs(gaps[~soft]).max(initial=0) <= OTHERS:
            return f"{_told(bodies.system, inputs, rows, gaps[soft] / bodies.system.weights[rows])}, while all others are closed"
    rows = candidates[0]
    gaps = found.gaps[np.isin(bodies.rows, rows)] / bodies.system.weights[rows]
    return f"{_told(bodies.system, inputs, rows, gaps)}, and other joints are open too"


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
        if size >= TAKES_PART * max(sizes.values()):
            kinds[_kind(system, name)].append(name)
    for each in kinds.values():
        each.sort(key=lambda name: -round(sizes[name] / max(sizes.values()) / LARGE))
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


def _told(system: System, inputs: Inputs, rows: np.ndarray, gaps: np.ndarray) -> str:
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
