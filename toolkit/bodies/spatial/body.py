"""Base of bodies in space, which says what the compilation asks of them; a new kind of body is one subclass."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import model_validator

from toolkit.bodies.body import QUATERNION, Body, Placed
from toolkit.description.description import Triple
from toolkit.description.quantity import Quantity
from toolkit.foundation.compiled.rows import filled_up
from toolkit.kinematics.spatial import angular_velocity, axes_along, matrix_of, quaternion_rate

ORIENTATION = ("e0", "e1", "e2", "e3")
"""Names of a quaternion's coordinates."""


class SpatialMarkerNumbers(NamedTuple):
    """A point on a body: z0 + Z c in its frame, with axes that the rotation vector T c turns."""

    point: np.ndarray  # (15,) z0, three axes, and the origin of a frame that only turns
    columns: np.ndarray  # (n_columns,) numbers within the body's coordinates; those of the frame first
    shape: np.ndarray  # (n_columns, 6) Z and T


class SpatialFloatingNumbers(NamedTuple):
    """Invariants of a body whose frame turns; all Q[a, b] and S[a, b] on their common pattern."""

    mass: Any
    moment: np.ndarray  # (1 + n_f, 3) N^T
    row: np.ndarray
    column: np.ndarray
    second: np.ndarray  # (n_entries, 9) Q[a, b], b running fastest
    axis: np.ndarray  # (3,) that a turning frame turns about
    stiffening: np.ndarray  # (n_entries, 9) S_ab - delta_ab tr S / 2; () of a body that no spin stiffens

    def times(self, factor: Any) -> SpatialFloatingNumbers:
        """All invariants times a factor, without the spin stiffening S."""
        return self._replace(
            mass=factor * self.mass, moment=factor * self.moment, second=factor * self.second, stiffening=np.zeros(())
        )

    @property
    def full(self) -> bool:
        """Whether the matrices Q[a, b] are worked with whole, because at least half of their entries can differ from zero.

        Those of a rigid body are single numbers, which whole rows would waste.
        """
        return len(self.moment) > 1 and 2 * len(self.row) >= len(self.moment) ** 2

    @property
    def whole(self) -> np.ndarray:
        """Rows of all Q[a, b] as whole matrices, for each row the nine rows a, b, filled up."""
        n = len(self.moment)
        rows: np.ndarray = np.zeros((n, 9, filled_up(n)), self.second.dtype)
        rows[self.row, :, self.column] = self.second
        return rows.ravel()

    @property
    def entries(self) -> int:
        """Number of entries of all Q[a, b], S[a, b] and N, and the mass."""
        return self.second.size + self.stiffening.size * (self.stiffening.ndim > 0) + self.moment.size + 1


class SpatialBody(Body):
    """Base of spatial bodies. Coordinates are x, y, z of the frame and its orientation, as far as it has them, then the elastic ones.

    Attributes
    ----------
    frame
        Coordinates that the frame has: "moving" three and a quaternion, "translating" three, "turning" one angle about `axis`,
        "grounded" none: then no joint can move the body as a whole.
    axis
        Axis through the frame's origin that a turning frame turns about, in the undeformed configuration, of any length.
    velocity
        Velocity of the frame's origin at the start, in length/time. What is written holds; left out, the origin starts as the joints ask,
        and rests if they ask for nothing.
    angular_velocity
        Angular velocity at the start, in the undeformed configuration's axes, in rad/time; of a turning frame along its axis. What is
        written holds; left out, the body turns as the joints ask.
    """

    dimension: ClassVar[int] = 3

    frame: Literal["moving", "translating", "turning", "grounded"] = "moving"
    axis: Annotated[Triple | None, Quantity("none")] = None
    velocity: Annotated[Triple | None, Quantity("length/time")] = None
    angular_velocity: Annotated[Triple | None, Quantity("angle/time")] = None

    @model_validator(mode="after")
    def _fits_its_frame(self) -> SpatialBody:
        if (self.frame == "turning") != (self.axis is not None):
            raise ValueError('`axis` belongs to frame = "turning" and to no other')
        if self.axis is not None and not any(self.axis):
            raise ValueError("an axis needs a direction, for example [0, 0, 1]")
        if any(self.velocity or ()) and not self.moves:
            raise ValueError(f'the origin of a frame = "{self.frame}" does not move: leave `velocity` out')
        if any(self.angular_velocity or ()) and not self.turns:
            raise ValueError(f'a frame = "{self.frame}" does not turn: leave `angular_velocity` out')
        if self.axis is not None and np.abs(np.cross(self.axis, self.spin)).max() > 1e-9 * max(map(abs, self.axis)):
            raise ValueError("`angular_velocity` of a turning frame is along its axis")
        return self

    def means(self, field: str) -> bool:
        """Whether a field's numbers mean something.

        Those of the axis that defines an angle do not, nor any velocity of a frame that has none.
        """
        return bool({"axis": 0, "velocity": self.moves, "angular_velocity": self.turns}.get(field, 1))

    @property
    def moves(self) -> int:
        """Number of coordinates of the frame's origin."""
        return 3 if self.frame in ("moving", "translating") else 0

    @property
    def turns(self) -> int:
        """Number of coordinates of the frame's orientation."""
        return {"moving": 4, "turning": 1}.get(self.frame, 0)

    @property
    def unit_axis(self) -> np.ndarray:
        """Direction of the axis of a turning frame, (3,)."""
        return axes_along(self.axis)[:, 2] if self.axis is not None else np.zeros(3)

    @property
    def spin(self) -> np.ndarray:
        """Written angular velocity at the start, (3,), or zero."""
        return np.zeros(3) if self.angular_velocity is None else np.array(self.angular_velocity)

    def written_velocities(self) -> dict[int, str]:
        """Coordinates with a written velocity -> keys of the velocities, those of the rotation first, which tell most."""
        turning = {} if self.angular_velocity is None else {self.moves + k: "angular_velocity" for k in range(self.turns)}
        return turning | ({} if self.velocity is None else {k: f"velocity.{k}" for k in range(self.moves)})

    def frame_names(self) -> list[str]:
        """Names of the frame's coordinates."""
        return [*"xyz"[: self.moves], *({4: ORIENTATION, 1: ("rotation",)}.get(self.turns, ()))]

    def frame_lengths(self) -> np.ndarray:
        """Lengths of the frame's displacements, 1 each, and nan for the coordinates of its orientation."""
        return np.array([1.0] * self.moves + [np.nan] * self.turns)

    def frame_state(self, origin: np.ndarray, quaternion: np.ndarray, omega: Any) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and velocities of the frame at the start; omega in the frame's axes."""
        turned: dict[int, Any] = {
            4: (quaternion, quaternion_rate(quaternion, omega)),
            1: ([0.0], [self.unit_axis @ self.spin]),
        }
        orientation, rate = turned.get(self.turns, ([], []))
        velocity = (self.velocity or (0.0, 0.0, 0.0))[: self.moves]
        return np.array([*origin[: self.moves], *orientation]), np.array([*velocity, *rate])

    def frame_motion(self, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        """Velocity of the frame's origin and angular velocity (3,), as far as the frame has them, by keys of the body's table.

        The angular velocity follows from the quaternion's rate, or lies along the axis of a turning frame.
        """
        found, turns = {}, v[self.moves : self.frame_size]
        if self.moves:
            found["velocity"] = v[: self.moves]
        if self.turns == QUATERNION:
            orientation = q[self.moves : self.frame_size]
            found["angular_velocity"] = matrix_of(orientation) @ angular_velocity(orientation, turns)
        elif self.turns:
            found["angular_velocity"] = turns[0] * self.unit_axis
        return found

    @abstractmethod
    def marker(self, scene: Placed, point: str, name: str, axes: np.ndarray | None = None) -> Any:
        """Marker on this body at the named point of the scene; `axes` (3, 3) in the undeformed configuration."""


def pose_of(position: np.ndarray, axes: np.ndarray, origin: np.ndarray | None = None) -> np.ndarray:
    """The numbers of a marker from its position (3,), its axes (3, 3), as columns, and a fixed origin of its frame (3,)."""
    return np.concatenate([position, axes.T.ravel(), np.zeros(3) if origin is None else origin])
