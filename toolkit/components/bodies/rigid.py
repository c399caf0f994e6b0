"""Rigid bodies: explicit mass properties, or a uniform rod between two points."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Any

import numpy as np
from pydantic import field_validator

from toolkit.components.bodies.body import (
    CENTRE,
    Body,
    ConstantNumbers,
    MarkerNumbers,
    Placed,
    SpatialBody,
    SpatialFloatingNumbers,
    SpatialMarkerNumbers,
    StartVelocity,
    no_constants,
    pose_of,
)
from toolkit.description.description import Number, Positive, Quantity, Scalar


class AnyRigidBody(Body):
    """Base of rigid bodies in the plane and in space: mass, centre of mass, moments about it."""

    @abstractmethod
    def mass_properties(self, scene: Placed) -> tuple[Scalar, np.ndarray, Scalar | np.ndarray]:
        """Mass, undeformed centre of mass (d,), and about it the moment of inertia, in space second moments int rho x_a x_b dV (3, 3)."""

    def properties(self, scene: Placed) -> tuple[Scalar, np.ndarray, Scalar | np.ndarray]:
        """Result of `mass_properties`, kept because many ask for it."""
        return scene.of_body(self, "mass", lambda: self.mass_properties(scene))

    def coordinate_names(self, _scene: Placed) -> list[str]:
        """Names of the coordinates, which are those of the frame."""
        return self.frame_names()

    def coordinate_lengths(self, _scene: Placed) -> np.ndarray:
        """Lengths of the frame's displacements, 1 each, and nan for the coordinates of its orientation."""
        return self.frame_lengths()

    def whole_mass(self, scene: Placed) -> Scalar:
        """Mass of the body, as it is given or of the rod."""
        return self.properties(scene)[0]


class GivenMass(AnyRigidBody):
    """Base of rigid bodies with explicit mass properties; the centre of mass is a point of the scene.

    Attributes
    ----------
    mass
        Mass of the body.
    center
        Point of the scene where the centre of mass is.
    """

    proportional = ("mass", "inertia")

    mass: Annotated[Positive, Quantity("mass")]
    center: str

    def named_points(self) -> tuple[str, ...]:
        """Names of the centre of mass and of a frame's origin elsewhere, on which the body is built."""
        return (self.center, *super().named_points())


class UniformRod(AnyRigidBody):
    """Base of uniform rods between two points.

    Attributes
    ----------
    between
        Points of the scene at its ends.
    area
        Area of the section, in length^2.
    density
        Mass/length^3.
    """

    proportional = ("density",)

    between: tuple[str, str]
    area: Annotated[Positive, Quantity("area")]
    density: Annotated[Positive, Quantity("density")]

    def named_points(self) -> tuple[str, ...]:
        """Names of both ends of the rod and of a frame's origin elsewhere, on which the body is built."""
        return (*self.between, *super().named_points())

    def line(self, scene: Placed) -> tuple[Scalar, np.ndarray, np.ndarray]:
        """Mass, middle (d,), and vector (d,) from the first to the second end."""
        start, end = (scene.position(point) for point in self.between)
        along = end - start
        return self.density * self.area * np.sqrt(along @ along), (start + end) / 2, along


class RigidBody(AnyRigidBody, StartVelocity):
    """Base of rigid bodies in the plane, whose frame sits at the centre of mass."""

    def initial_state(self, scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates in the undeformed position, and the given velocities."""
        return np.append(self.properties(scene)[1], 0.0), self.frame_velocity()

    def radius_of_gyration(self, scene: Placed) -> float:
        """Radius of gyration about the centre of mass."""
        mass, _, inertia = self.properties(scene)
        return float(np.sqrt(np.real(inertia) / np.real(mass))) if np.real(mass) else 0.0

    def marker(self, scene: Placed, point: str, _name: str) -> MarkerNumbers:
        """Marker at any point of the scene, since a rigid body can be gripped anywhere."""
        centre = self.properties(scene)[1]
        z0 = (centre if point == CENTRE else scene.position(point)) - centre
        return MarkerNumbers(np.append(z0, 0.0), np.arange(3), np.zeros((3, 3)))

    def constant(self, scene: Placed, gravity: np.ndarray) -> ConstantNumbers:
        """Constant terms of the body: diagonal mass matrix and weight."""
        mass, _, inertia = self.properties(scene)
        diagonal, zero = np.arange(3), np.zeros(3)
        return ConstantNumbers(diagonal, diagonal, np.array([mass, mass, inertia]), zero, zero, np.append(mass * gravity, 0.0))


class Rigid(GivenMass, RigidBody):
    """A rigid body with explicit mass properties; its centre of mass is a point of the scene.

    Attributes
    ----------
    inertia
        Moment of inertia about the centre of mass, in mass length^2.
    """

    kind = "rigid"

    inertia: Annotated[Positive, Quantity("mass length^2")]

    def mass_properties(self, scene: Placed) -> tuple[Scalar, np.ndarray, Scalar]:
        """Given mass, undeformed global centre of mass (2,), and given moment of inertia about it."""
        return self.mass, scene.position(self.center), self.inertia


class Rod(UniformRod, RigidBody):
    """A uniform slender rod between two points: m = density area L, inertia m L^2 / 12; it follows when a point moves."""

    kind = "rod"

    def mass_properties(self, scene: Placed) -> tuple[Scalar, np.ndarray, Scalar]:
        """Mass, undeformed global centre of mass (2,), and moment of inertia about it, from the end points of the rod."""
        mass, middle, along = self.line(scene)
        return mass, middle, mass * (along @ along) / 12


INERTIA = ("xx", "yy", "zz", "yz", "xz", "xy")
"""Order of moments of inertia."""
NEGATIVE_MOMENT_TOLERANCE = 1e-9
"""Relative negative moment of second order that is round-off of the given inertia."""


class SpatialRigidBody(AnyRigidBody, SpatialBody):
    """Base of rigid bodies in space, whose frame sits at the centre of mass, or at `origin`.

    Attributes
    ----------
    origin
        Point of the scene where the frame's origin is; by default the centre of mass. A turning frame turns about this point.
    """

    origin: str | None = None

    def named_points(self) -> tuple[str, ...]:
        """Name of the frame's origin, where that is a point of the scene."""
        return () if self.origin is None else (self.origin,)

    def frame_origin(self, scene: Placed) -> np.ndarray:
        """Undeformed position of the frame's origin, (3,)."""
        return self.properties(scene)[1] if self.origin is None else scene.position(self.origin)

    def initial_state(self, scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates in the undeformed position, and the given velocities."""
        return self.frame_state(self.frame_origin(scene), np.array([1.0, 0, 0, 0]), self.spin)

    def radius_of_gyration(self, scene: Placed) -> float:
        """Root of the mean square distance from the centre of mass."""
        mass, _, moments = self.properties(scene)
        return float(np.sqrt(np.real(np.trace(moments)) / np.real(mass)))

    def marker(self, scene: Placed, point: str, _name: str, axes: np.ndarray | None = None) -> SpatialMarkerNumbers:
        """Marker at any point of the scene, since a rigid body can be gripped anywhere."""
        origin = self.frame_origin(scene) if self.frame_size else np.zeros(3)
        axes = np.eye(3) if axes is None else axes
        place = self.properties(scene)[1] if point == CENTRE else scene.position(point)
        pose = pose_of(place - origin, axes, origin if self.frame == "turning" else 0 * origin)
        return SpatialMarkerNumbers(pose, np.arange(self.frame_size), np.zeros((self.frame_size, 6)))

    def constant(self, scene: Placed, gravity: np.ndarray) -> ConstantNumbers:
        """Constant terms of a body that does not turn: mass and weight."""
        if self.turns or not self.moves:
            return no_constants(self.frame_size)
        mass, diagonal, zero = self.properties(scene)[0], np.arange(3), np.zeros(3)
        return ConstantNumbers(diagonal, diagonal, mass * np.ones(3), zero, zero, mass * gravity)

    def floating(self, scene: Placed) -> SpatialFloatingNumbers | None:
        """Invariants of a body that turns: its moments about the frame's origin; None of other bodies."""
        if not self.turns:
            return None
        mass, center, moments = self.properties(scene)
        arm = center - self.frame_origin(scene)
        second = moments + mass * np.outer(arm, arm)
        first = np.zeros(1, int)
        return SpatialFloatingNumbers(mass, (mass * arm)[None], first, first, second.reshape(1, 9), self.unit_axis, np.zeros(()))


class SpatialRigid(GivenMass, SpatialRigidBody):
    """A rigid body with explicit mass properties; its centre of mass is a point of the scene.

    Attributes
    ----------
    inertia
        Moments of inertia about the centre of mass, in mass length^2: xx, yy, zz in the undeformed configuration's axes, and as many
        as three entries more, yz, xz, xy of the inertia tensor (the negative products of inertia).
    """

    kind = "rigid"

    inertia: Annotated[
        tuple[Number, Number, Number] | tuple[Number, Number, Number, Number, Number, Number], Quantity("mass length^2")
    ]

    @field_validator("inertia")
    @classmethod
    def _physical(cls, inertia: tuple) -> tuple:
        moments = second_moments(np.array(inertia))
        if np.linalg.eigvalsh(moments)[0] < -NEGATIVE_MOMENT_TOLERANCE * np.trace(moments) or not np.trace(moments) > 0:
            raise ValueError(
                "no body has these moments of inertia: each principal one is positive and at most the sum of the other two; "
                "fix a digit, or the signs of yz, xz, xy"
            )
        return inertia

    def mass_properties(self, scene: Placed) -> tuple[Scalar, np.ndarray, np.ndarray]:
        """Given mass, undeformed centre of mass (3,), and second moments about it (3, 3) from the given moments of inertia."""
        return self.mass, scene.position(self.center), second_moments(np.array(self.inertia))


class SpatialRod(UniformRod, SpatialRigidBody):
    """A uniform round rod between two points: m = density area L, about its middle m L^2 / 12 along it and m area / (4 pi) across."""

    kind = "rod"

    def mass_properties(self, scene: Placed) -> tuple[Scalar, np.ndarray, np.ndarray]:
        """Mass, undeformed centre of mass (3,), and second moments about it (3, 3), from the end points of the rod."""
        mass, middle, along = self.line(scene)
        square = along @ along
        along = np.outer(along, along) / square
        return mass, middle, mass * (square / 12 * along + self.area / (4 * np.pi) * (np.eye(3) - along))


def second_moments(inertia: np.ndarray) -> np.ndarray:
    """Second moments int rho x_a x_b dV (3, 3) from the inertia tensor Theta: tr(Theta) / 2 I - Theta.

    Theta has 3 or 6 numbers in the order of `INERTIA`.
    """
    xx, yy, zz, *rest = inertia
    yz, xz, xy = rest or (0 * xx, 0 * xx, 0 * xx)
    tensor: Any = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return (xx + yy + zz) / 2 * np.eye(3) - tensor
