"""Small errors of the parts of a body in the plane, joined to one of the body.

Each part has been bent in its own frame by some w_k, with a rotation at every node. Neighbours stay tied, so that part k follows the rigid
motion which brings its node n to where the part before has it:

    E(x) = w_k(x) + E(n) - w_k(n) + (phi(n) - phi_k(n)) e_z x (x - x_n)

Of this the body's own rigid motion is none of its errors: that of a node that is held, or, of a moving body, that which fits best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class BentPart:
    """Nodes of a part by their numbers in the body, where they are, and their errors in the same axes."""

    nodes: np.ndarray  # (n,)
    places: np.ndarray  # (n_t, n, 2)
    errors: np.ndarray  # (n_t, n, 3) displacements and rotation


def joined_errors(parts: Sequence[BentPart], held: int | None) -> np.ndarray:
    """Errors (n_t, n_nodes, 2) of the nodes of a body, of which one is held or none."""
    count, times = 1 + max(part.nodes.max() for part in parts), len(parts[0].errors)
    places, found = np.zeros((times, count, 2)), np.zeros((times, count, 3))
    joined, waiting = set(parts[0].nodes[:1].tolist()), list(parts)
    while waiting:
        part = next((each for each in waiting if joined.intersection(each.nodes.tolist())), waiting[0])
        waiting.remove(part)
        n = next((k for k, node in enumerate(part.nodes) if int(node) in joined), 0)
        start = found[:, part.nodes[n]] - part.errors[:, n]
        new = [k for k, node in enumerate(part.nodes) if k == n or int(node) not in joined]
        places[:, part.nodes] = part.places
        found[:, part.nodes[new]] = part.errors[:, new] + _rigid(start, part.places[:, new] - part.places[:, n : n + 1])
        joined |= set(part.nodes.tolist())
    if held is not None:
        return (found - _rigid(found[:, held], places - places[:, held : held + 1]))[:, :, :2]
    return _without_best(found[:, :, :2], places)


def _rigid(motion: np.ndarray, arms: np.ndarray) -> np.ndarray:
    """Displacements and rotation (n_t, n, 3) of points at arms (n_t, n, 2) by those of their origin (n_t, 3)."""
    turn = motion[:, 2:]
    moved = motion[:, None, :2] + np.stack([-turn * arms[:, :, 1], turn * arms[:, :, 0]], axis=2)
    return np.concatenate([moved, np.broadcast_to(turn[:, None], (*arms.shape[:2], 1))], axis=2)


def _without_best(errors: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Without the rigid motion that leaves the least squares."""
    arms = places - places.mean(axis=1, keepdims=True)
    across = np.stack([-arms[:, :, 1], arms[:, :, 0]], axis=2)
    turn = np.einsum("tni,tni->t", across, errors) / np.einsum("tni,tni->t", arms, arms)
    found: np.ndarray = errors - errors.mean(axis=1, keepdims=True) - turn[:, None, None] * across
    return found
