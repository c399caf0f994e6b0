"""The stiffness that forces of inertia give a body in a state of a motion, as if they kept their size and direction.

Without them such a state is not in balance, and what its second derivatives say of stability depends on where the frames of its bodies
have their origins: with all of them on the axis, the parts of a beam that spins seem to fall outwards. Held in balance by the force -g on
the centre of mass c of a body, in its frame's axes, a turn meets

    g . A c   in the plane,   -g . d^2 (A c) / dp^2 + 2 (g . A c) 1   in space, with the quaternion p and its length
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from toolkit.bodies.body import QUATERNION
from toolkit.kinematics.orientation import partials_of_quaternion, rotation
from toolkit.system.flexible_bodies import deforming
from toolkit.system.system import System


class TurningBody(NamedTuple):
    """A flexible body with a frame that moves and turns; of rigid ones the origin is the centre of mass."""

    body: Any
    first: int  # of its coordinates
    elastic: slice  # among them
    centre: np.ndarray  # (d, 1 + n_f) its centre of mass by [1; q_f]

    def stiffness(self, q: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Matrices (k, turns, turns) of states by the body's coordinates (k, size) and what is left of the forces on it (k, d)."""
        centre = self.centre[:, 0] + q[:, self.elastic] @ self.centre[:, 1:].T
        if len(self.centre) == 2:
            angles: Any = q[:, 2]
            axes = np.moveaxis(rotation(angles), -1, 0)
        else:
            axes = np.stack([self.body.frame_axes(each) for each in q])
        return stiffness_of_turns(force, centre, axes, self.body.turns)


def dead_inertia(system: System, q: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Rows (m,), columns (m,) and values (k, m), each at another place, of what all flexible bodies add to the matrices of some states.

    None if there are no such bodies.

    Parameters
    ----------
    q, residual : (k, n)
        Coordinates of the states, and what is left of their forces without inertia.
    """
    rows, columns, values = [], [], []
    for each in system.scene.once(("turning bodies",), lambda: turning_bodies(system)):
        d, body = len(each.centre), each.body
        own = q[:, each.first : each.first + each.elastic.stop]
        at = each.first + body.moves + np.arange(body.turns)
        rows.append(np.repeat(at, body.turns))
        columns.append(np.tile(at, body.turns))
        values.append(each.stiffness(own, residual[:, each.first : each.first + d]).reshape(len(q), -1))
    return (np.concatenate(rows), np.concatenate(columns), np.concatenate(values, axis=1)) if values else None


def turning_bodies(system: System) -> list[TurningBody]:
    """All of a scene; what they are does not depend on a state."""
    found = []
    for name, body in deforming(system.scene).items():
        if body.moves and body.turns in (1, QUATERNION):
            mass, moment = body.some_invariants(system.scene, "mass", "first_moment")
            elastic = slice(body.frame_size, body.frame_size + moment.shape[1] - 1)
            found.append(TurningBody(body, system.numbering.first[name], elastic, np.real(moment) / np.real(mass)))
    return found


def stiffness_of_turns(force: np.ndarray, centre: np.ndarray, axes: np.ndarray, turns: int) -> np.ndarray:
    """Matrices (..., turns, turns) that forces -g (..., d) on centres (..., d) add, with axes A (..., d, d) that an angle or a quaternion
    turns."""
    along = np.einsum("...i,...ij,...j->...", force, axes, centre)[..., None, None]
    if turns == 1:
        return along
    second = np.stack([partials_of_quaternion(unit) for unit in np.eye(QUATERNION)])  # (4, 4, 3, 3)
    found: np.ndarray = 2 * along * np.eye(QUATERNION) - np.einsum("...a,ijab,...b->...ij", force, second, centre)
    return found
