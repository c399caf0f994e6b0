"""The motion of a whole scene about an axis, coordinate by coordinate.

A frame that turns with omega about a point c moves its coordinates linearly:

    r' = omega x (r - c),   p' = (0, omega) o p / 2,   theta' = omega,   q_f' = 0        or   v = S q + s,   a = S v

S is constant while the scene turns, whatever its bodies do in their frames. Bodies on a grounded frame stay where they are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from toolkit.bodies.body import QUATERNION, Body
from toolkit.kinematics.spatial import skew
from toolkit.system.system import System


class Generator(NamedTuple):
    """Matrix S (n_q, n_q) and vector s (n_q,) of a motion v = S q + s of all coordinates."""

    matrix: np.ndarray
    offset: np.ndarray

    def velocity(self, q: np.ndarray) -> np.ndarray:
        """Velocity S q + s at coordinates q (n_q,)."""
        return self.matrix @ q + self.offset

    def acceleration(self, q: np.ndarray) -> np.ndarray:
        """Acceleration S v at coordinates q (n_q,)."""
        return self.matrix @ self.velocity(q)

    def times(self, factor: float) -> Generator:
        """Generator of the same motion at another speed."""
        return Generator(factor * self.matrix, factor * self.offset)

    def turned(self, q: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates after a time, and the matrix that turns their changes and their forces, (n_q, n_q)."""
        n_q = len(q)
        whole = scipy.linalg.expm(time * np.block([[self.matrix, self.offset[:, None]], [np.zeros((1, n_q + 1))]]))
        return whole[:n_q, :n_q] @ q + whole[:n_q, n_q], whole[:n_q, :n_q]


def generator(system: System, omega: np.ndarray, centre: np.ndarray) -> Generator:
    """Generator of an angular velocity (1,), in space (3,) in the axes of space, about a point (d,); real or complex."""
    blocks, offsets = [], []
    for name in system.scene.pieces():
        size = _size(system, name)
        matrix, offset = _of_frame(system.scene.body(name), omega, centre)
        kept = size - len(offset)
        blocks.append(scipy.linalg.block_diag(matrix, np.zeros((kept, kept))) if size else np.zeros((0, 0)))
        offsets.append(np.append(offset, np.zeros(kept)))
    states = np.zeros(len(system.numbering.states))  # of loads, which stay what they are
    blocks.append(np.diag(states))
    offsets.append(states)
    return Generator(scipy.linalg.block_diag(*blocks), np.concatenate(offsets))


def angular_velocity(system: System, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Mean angular velocity (1,), in space (3,), of all frames that can turn, from q, v (n_q,); zero if there are none."""
    rates = []
    for name in system.scene.pieces():
        body, first = system.scene.body(name), system.numbering.first[name]
        at = slice(first, first + body.frame_size)
        rate = body.frame_motion(q[at], v[at]).get("angular_velocity")
        if rate is not None:
            rates.append(rate)
    none = np.zeros(1 if system.scene.space.rotations_add else 3)
    return np.mean(rates, axis=0) if rates else none


def axis_of_turning(body: Body) -> np.ndarray:
    """Unit vector, (1,) in the plane, in space (3,), that one angle turns about."""
    unit = np.zeros(body.frame_size)
    unit[body.moves] = 1.0
    return body.frame_motion(unit, unit)["angular_velocity"]


def _size(system: System, name: str) -> int:
    edges = [*system.numbering.first.values(), system.n_q]
    number = list(system.numbering.first).index(name)
    return edges[number + 1] - edges[number]


def _of_frame(body: Body, omega: np.ndarray, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    across = skew(omega) if len(omega) > 1 else omega[0] * np.array([[0.0, -1.0], [1.0, 0.0]])
    moving = across[: body.moves, : body.moves]
    offset = -(across @ centre)[: body.moves]
    if body.turns == QUATERNION:
        return scipy.linalg.block_diag(moving, left_product(np.append(0 * omega[:1], omega)) / 2), np.append(
            offset, np.zeros(QUATERNION)
        )
    rate = [axis_of_turning(body) @ omega] if body.turns else []
    return scipy.linalg.block_diag(moving, np.zeros((body.turns, body.turns))), np.append(offset, rate)


def left_product(quaternion: np.ndarray) -> np.ndarray:
    """Matrix (4, 4) of the product p -> quaternion o p."""
    a, b, c, d = quaternion
    return np.array([[a, -b, -c, -d], [b, a, -d, c], [c, d, a, -b], [d, -c, b, a]])
