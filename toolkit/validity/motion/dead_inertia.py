"""The stiffness that forces of inertia give a body in a state of a motion, as if they kept their size and direction.

Without them such a state is not in balance, and what its second derivatives say of stability depends on where the frames of its bodies
have their origins: with all of them on the axis, the parts of a beam that spins seem to fall outwards. Held in balance by the force -g on
the centre of mass c of a body, in its frame's axes, a turn meets

    g . A c   in the plane,   -g . d^2 (A c) / dp^2 + 2 (g . A c) 1   in space, with the quaternion p and its length
"""

from __future__ import annotations

import numpy as np
import scipy

from toolkit.bodies.body import QUATERNION
from toolkit.kinematics.spatial import partials_of_quaternion
from toolkit.system.flexible_bodies import deforming
from toolkit.system.system import System


def dead_inertia(system: System, q: np.ndarray, residual: np.ndarray) -> scipy.sparse.coo_array | None:
    """Matrix (n, n) of all flexible bodies with a frame that moves and turns; of rigid ones the origin is the centre of mass. None if there
    are no such bodies.

    Parameters
    ----------
    q, residual : (n,)
        Coordinates of a state, and what is left of its forces without inertia.
    """
    rows, columns, values = [], [], []
    for name, body in deforming(system.scene).items():
        if not (body.moves and body.turns in (1, QUATERNION)):
            continue
        first, d = system.numbering.first[name], system.scene.dimension
        mass, moment = body.some_invariants(system.placed, "mass", "first_moment")
        own = q[first : first + body.frame_size + moment.shape[1] - 1]
        centre = np.real(moment @ np.append(1.0, own[body.frame_size :])) / np.real(mass)
        block = stiffness_of_turns(residual[first : first + d], centre, body.frame_axes(own), body.turns)  # type: ignore[attr-defined]
        at = first + body.moves + np.arange(body.turns)
        rows.append(np.repeat(at, body.turns))
        columns.append(np.tile(at, body.turns))
        values.append(block.ravel())
    if not values:
        return None
    places = np.concatenate(rows), np.concatenate(columns)
    return scipy.sparse.coo_array((np.concatenate(values), places), shape=(system.n, system.n))


def stiffness_of_turns(force: np.ndarray, centre: np.ndarray, axes: np.ndarray, turns: int) -> np.ndarray:
    """Matrix (turns, turns) that a force -g (d,) on a centre (d,) adds, with axes A (d, d) that an angle or a quaternion turns."""
    along = force @ axes @ centre
    if turns == 1:
        return np.array([[along]])
    second = np.stack([partials_of_quaternion(unit) for unit in np.eye(QUATERNION)])  # (4, 4, 3, 3)
    return 2 * along * np.eye(QUATERNION) - np.einsum("a,ijab,b->ij", force, second, centre)
