"""Bases of all bodies, in the plane and in space, which say what the compilation asks of a body; a new kind of body is one subclass."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Hashable, Mapping
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Protocol, TypeVar

import numpy as np
from pydantic import model_validator

from toolkit.components.bodies.chain_strains import Strains, no_strains
from toolkit.description.description import InSpace, Number, Quantity, Scalar, Triple
from toolkit.description.design import BodyPoint, Point
from toolkit.foundation.compiled.rows import filled_up
from toolkit.foundation.kinematics.orientation import angular_velocity, axes_along, matrix_of, quaternion_rate
from toolkit.reduced_model.model import ReducedModel

T = TypeVar("T")
CENTRE = "(centre of mass)"
"""Name in place of a point of the scene: a body's centre of mass, which moves in a body that deforms."""
QUATERNION = 4
"""Coordinates of an orientation that has a length to keep."""
ORIENTATION = ("e0", "e1", "e2", "e3")
"""Names of a quaternion's coordinates."""


class Placed(Protocol):
    """Interface of a scene to its bodies: where the points are, and the bodies' reduced models."""

    @property
    def bodies(self) -> Mapping[str, Body]:
        """All bodies but the ground, by name."""

    def position(self, point: str) -> np.ndarray:
        """Undeformed global position of a point, shape (d,)."""

    def interface(self, point: str) -> Point | BodyPoint:
        """Description of a point as the user wrote it."""

    def model(self, path: str, *parts: str) -> ReducedModel:
        """Parts of the reduced model in a file, whose path is relative to the scene's folder."""

    def arc_lengths(self, body: Body) -> dict[str, Scalar]:
        """Interface points of a body that the scene puts elsewhere along it, by their names in the reduced model."""

    def of_body(self, body: Body, what: Hashable, make: Callable[[], T]) -> T:
        """Result of a computation for one body of the scene; a scene that remembers its answers has it made once."""


class ConstantNumbers(NamedTuple):
    """Entries of constant mass, damping and stiffness matrices within the body's coordinates, and the force of gravity."""

    row: np.ndarray
    column: np.ndarray
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    force: np.ndarray  # (size,)
    strains: Strains = no_strains()  # the same stiffness in its factors, where these are known


class Body(InSpace):
    """Base of all bodies. Coordinates are those of the origin of its frame, then those of its orientation, then the elastic ones."""

    siblings: ClassVar[str] = "PlanarBody or SpatialBody"
    proportional: ClassVar[tuple[str, ...]] = ()
    """Fields that mass and moments of inertia are proportional to, of a body that does not deform."""

    @property
    @abstractmethod
    def moves(self) -> int:
        """Number of coordinates of the frame's origin."""

    @property
    @abstractmethod
    def turns(self) -> int:
        """Number of coordinates of the frame's orientation."""

    @property
    def frame_size(self) -> int:
        """Number of the frame's coordinates, which come before the elastic ones."""
        return self.moves + self.turns

    @property
    def has_frame(self) -> bool:
        """Whether the body has coordinates of a frame, which come before the elastic ones."""
        return self.frame_size > 0

    def frame_names(self) -> list[str]:
        """Names of the frame's coordinates."""
        return [*"xyz"[: self.moves], *({4: ORIENTATION, 1: ("rotation",)}.get(self.turns, ()))]

    def frame_lengths(self) -> np.ndarray:
        """Lengths of the frame's displacements, 1 each, and nan for the coordinates of its orientation."""
        return np.array([1.0] * self.moves + [np.nan] * self.turns)

    def named_points(self) -> tuple[str, ...]:
        """Points of the scene that the body is built on."""
        return ()

    @abstractmethod
    def coordinate_names(self, scene: Placed) -> list[str]:
        """Names of the coordinates, for messages; their number is the body's size."""

    @abstractmethod
    def initial_state(self, scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and velocities at the start."""

    def written_velocities(self) -> dict[int, str]:
        """Coordinates whose velocity at the start is written, so that it holds -> key of the body's table that says so.

        The velocities of all others, whatever `initial_state` gives them, are where the search for velocities that fit begins.
        """
        return {}

    @abstractmethod
    def frame_motion(self, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        """Motion of the frame in the numbers that a scene writes: key of the body's table -> numbers, as far as the frame moves.

        From the body's coordinates q and velocities v: "velocity" (d,) of the frame's origin, "angular_velocity" in rad/time, (1,) in the
        plane, in space (3,) in the axes of space.
        """

    @abstractmethod
    def coordinate_lengths(self, scene: Placed) -> np.ndarray:
        """Displacement that a unit of each coordinate stands for; nan for angles."""

    @abstractmethod
    def radius_of_gyration(self, scene: Placed) -> float:
        """sqrt(I / m) of the undeformed body about its frame's origin: its size, where points tell nothing."""

    @abstractmethod
    def marker(self, scene: Placed, point: str, name: str) -> MarkerNumbers | SpatialMarkerNumbers:
        """Marker on this body at the named point of the scene."""

    @abstractmethod
    def constant(self, scene: Placed, gravity: np.ndarray) -> ConstantNumbers:
        """Constant terms of the body's equations of motion."""

    @abstractmethod
    def whole_mass(self, scene: Placed) -> Scalar:
        """Mass of the body."""

    def floating(self, _scene: Placed) -> FloatingNumbers | SpatialFloatingNumbers | None:
        """Invariants of a flexible body with a moving frame; None of other bodies."""
        return None

    def drag(self, _scene: Placed) -> FloatingNumbers | SpatialFloatingNumbers | None:
        """Invariants of a moving frame, each times the body's mass-proportional damping; None if it has neither."""
        return None

    def model_values(self) -> Mapping[str, Scalar]:
        """Values of the parameters of the body's reduced model that the scene sets."""
        return {}


def no_constants(size: int) -> ConstantNumbers:
    """Constant terms without entries, for a body of this size all of whose terms move with its frame."""
    empty = np.zeros(0, int)
    return ConstantNumbers(empty, empty, np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(size))


class MarkerNumbers(NamedTuple):
    """A point on a body: position z0 + Z c in the body, angle theta + t0 + T c since the undeformed configuration."""

    point: np.ndarray  # (3,) z0, t0
    columns: np.ndarray  # (n_columns,) numbers within the body's coordinates; 0, 1, 2 first if the body has a frame
    shape: np.ndarray  # (n_columns, 3) Z and T


class FloatingNumbers(NamedTuple):
    """Invariants of a flexible body with a moving frame; G, H and S on their common pattern."""

    mass: Scalar | np.ndarray
    moment: np.ndarray  # (1 + n_f, 2) N^T
    row: np.ndarray
    column: np.ndarray
    inertia: np.ndarray
    gyroscopic: np.ndarray
    stiffening: np.ndarray  # S on the same entries; () of a body that no spin stiffens

    def times(self, factor: Scalar) -> FloatingNumbers:
        """All invariants times a factor, without the spin stiffening S."""
        return self._replace(
            mass=factor * self.mass,
            moment=factor * self.moment,
            inertia=factor * self.inertia,
            gyroscopic=factor * self.gyroscopic,
            stiffening=np.zeros(()),
        )

    @property
    def entries(self) -> int:
        """Number of entries of G, H and S and of the three rows and columns of the frame."""
        return len(self.row) + self.stiffening.size * (self.stiffening.ndim > 0) + 3 * (2 * len(self.moment) + 1)


class PlanarBody(Body):
    """Base of bodies in the plane. Coordinates are r_x, r_y, theta if the body has a frame, then the elastic ones."""

    dimension: ClassVar[int] = 2

    @property
    def has_frame(self) -> bool:
        """Whether the body's coordinates start with r_x, r_y, theta."""
        return True

    @property
    def moves(self) -> int:
        """Number of coordinates r_x, r_y of the frame's origin: 2, or 0 without a frame."""
        return 2 if self.has_frame else 0

    @property
    def turns(self) -> int:
        """Number of angles theta of the frame: 1, or 0 without a frame."""
        return 1 if self.has_frame else 0

    def frame_motion(self, _q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        """Velocity of the frame's origin (2,) and angular velocity (1,), by keys of the body's table; empty without a frame."""
        return {"velocity": v[:2], "angular_velocity": v[2:3]} if self.has_frame else {}


class StartVelocity(PlanarBody):
    """Base of planar bodies whose frame moves. What is written holds at the start; what is not, the joints and least motion decide.

    Attributes
    ----------
    velocity
        v_x, v_y of the frame's origin and omega at the start, in length/time and rad/time; the origin of a rigid body is its centre of
        mass. Left out, the body starts as the joints ask, and rests if they ask for nothing.
    angular_velocity
        omega at the start alone, in rad/time, in the place of `velocity`: the joints find what belongs to it.
    """

    velocity: Annotated[tuple[Number, Number, Number] | None, Quantity("length/time", "length/time", "angle/time")] = None
    angular_velocity: Annotated[Number | None, Quantity("angle/time")] = None

    @model_validator(mode="after")
    def _one_omega(self) -> StartVelocity:
        if self.velocity is not None and self.angular_velocity is not None:
            raise ValueError("the third number of `velocity` is the angular velocity already: write one of the two")
        return self

    def written_velocities(self) -> dict[int, str]:
        """Coordinates with a written velocity -> keys of the velocity, omega first, which tells most."""
        if not self.has_frame:
            return {}
        if self.velocity is not None:
            return {2: "velocity.2", 0: "velocity.0", 1: "velocity.1"}
        return {} if self.angular_velocity is None else {2: "angular_velocity"}

    def frame_velocity(self) -> np.ndarray:
        """v_x, v_y, omega (3,), zero where nothing is written."""
        if self.velocity is not None:
            return np.array(self.velocity)
        return np.array([0.0, 0.0, 0.0 if self.angular_velocity is None else self.angular_velocity])


class SpatialMarkerNumbers(NamedTuple):
    """A point on a body: z0 + Z c in its frame, with axes that the rotation vector T c turns."""

    point: np.ndarray  # (15,) z0, three axes, and the origin of a frame that only turns
    columns: np.ndarray  # (n_columns,) numbers within the body's coordinates; those of the frame first
    shape: np.ndarray  # (n_columns, 6) Z and T


class SpatialFloatingNumbers(NamedTuple):
    """Invariants of a body whose frame turns; all Q[a, b] and S[a, b] on their common pattern."""

    mass: Scalar | np.ndarray
    moment: np.ndarray  # (1 + n_f, 3) N^T
    row: np.ndarray
    column: np.ndarray
    second: np.ndarray  # (n_entries, 9) Q[a, b], b running fastest
    axis: np.ndarray  # (3,) that a turning frame turns about
    stiffening: np.ndarray  # (n_entries, 9) S_ab - delta_ab tr S / 2; () of a body that no spin stiffens

    def times(self, factor: Scalar) -> SpatialFloatingNumbers:
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

    def frame_state(self, origin: np.ndarray, quaternion: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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
    def marker(self, scene: Placed, point: str, name: str, axes: np.ndarray | None = None) -> SpatialMarkerNumbers:
        """Marker on this body at the named point of the scene; `axes` (3, 3) in the undeformed configuration."""


def pose_of(position: np.ndarray, axes: np.ndarray, origin: np.ndarray | None = None) -> np.ndarray:
    """The numbers of a marker from its position (3,), its axes (3, 3), as columns, and a fixed origin of its frame (3,)."""
    return np.concatenate([position, axes.T.ravel(), np.zeros(3) if origin is None else origin])
