"""Small errors of the parts of a body, joined to one of the body; those of the plane as errors in space that stay in it.

Each part has been bent in its own frame by some w_k, with a rotation at every node. Neighbours stay tied, so that part k follows the rigid
motion which brings its node n to where the part before has it:

    E(x) = w_k(x) + E(n) - w_k(n) + (phi(n) - phi_k(n)) x (x - x_n)

Of this the body's own rigid motion is none of its errors: that of a node that is held, or, of a moving body, that which fits best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

STRAIGHT = 1e-9
"""Part of the largest moment of inertia of a body's nodes below which a turn moves none of them."""


@dataclass(frozen=True, eq=False)
class BentPart:
    """A part of a body: its nodes by their numbers in the body, their positions, and their errors in the same axes."""

    nodes: np.ndarray  # (n,)
    places: np.ndarray  # (n_t, n, 3)
    errors: np.ndarray  # (n_t, n, 6) displacements and rotations


def in_space(moves: np.ndarray, turns: np.ndarray | None = None) -> np.ndarray:
    """Vectors in space (.., 3) from those in the plane or in space, (.., d); with rotations (.., 1 or 3) behind them (.., 6)."""
    found = np.zeros((*moves.shape[:-1], 3 if turns is None else 6))
    found[..., : moves.shape[-1]] = moves
    if turns is not None:
        found[..., 6 - turns.shape[-1] :] = turns
    return found


def joined_errors(parts: Sequence[BentPart], held: int | None) -> np.ndarray:
    """Errors (n_t, n_nodes, 3) of the nodes of a body, of which one or none is held, joined from those of its parts."""
    count, times = 1 + max(part.nodes.max() for part in parts), len(parts[0].errors)
    places, found = np.zeros((times, count, 3)), np.zeros((times, count, 6))
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
        return (found - _rigid(found[:, held], places - places[:, held : held + 1]))[:, :, :3]
    return _without_best(found[:, :, :3], places)


def _rigid(motion: np.ndarray, arms: np.ndarray) -> np.ndarray:
    """Displacements and rotations (n_t, n, 6) of points at arms (n_t, n, 3) by those of their origin (n_t, 6)."""
    moved = motion[:, None, :3] + np.cross(motion[:, None, 3:], arms)
    return np.concatenate([moved, np.broadcast_to(motion[:, None, 3:], arms.shape)], axis=2)


def _without_best(errors: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Errors (n_t, n, 3) without the rigid motion that leaves the least squares."""
    arms = places - places.mean(axis=1, keepdims=True)
    inertia = np.einsum("tni,tni,jk->tjk", arms, arms, np.eye(3)) - np.einsum("tnj,tnk->tjk", arms, arms)
    moment = np.cross(arms, errors).sum(axis=1)
    turn = np.einsum("tjk,tk->tj", np.linalg.pinv(inertia, rcond=STRAIGHT, hermitian=True), moment)
    found: np.ndarray = errors - errors.mean(axis=1, keepdims=True) - np.cross(turn[:, None], arms)
    return found
