"""Rigid bodies: explicit mass properties, or a uniform rod between two points. The frame sits at the centre of mass."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Any

import numpy as np

from toolkit.bodies.body import CENTRE, ConstantNumbers, Placed
from toolkit.bodies.mass import GivenMass, UniformRod
from toolkit.bodies.planar.body import MarkerNumbers
from toolkit.bodies.planar.start_velocity import StartVelocity
from toolkit.description.description import Positive
from toolkit.description.quantity import Quantity


class RigidBody(StartVelocity):
    """Base of rigid bodies: mass, centre of mass, moment of inertia about it."""

    @abstractmethod
    def mass_properties(self, scene: Placed) -> tuple[Any, np.ndarray, Any]:
        """Mass, undeformed global centre of mass (2,), moment of inertia about it."""

    def properties(self, scene: Placed) -> tuple[Any, np.ndarray, Any]:
        """Result of `mass_properties`, kept because many ask for it."""
        return scene.of_body(self, "mass", lambda: self.mass_properties(scene))

    def coordinate_names(self, _scene: Placed) -> list[str]:
        """Names of the coordinates: position of the centre of mass, and rotation."""
        return ["x", "y", "rotation"]

    def initial_state(self, scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates in the undeformed position, and the given velocities."""
        return np.append(self.properties(scene)[1], 0.0), self.frame_velocity()

    def coordinate_lengths(self, _scene: Placed) -> np.ndarray:
        """Lengths of two displacements and nan for the angle, (3,)."""
        return np.array([1.0, 1.0, np.nan])

    def whole_mass(self, scene: Placed) -> Any:
        """Mass of the body, as it is given or of the rod."""
        return self.properties(scene)[0]

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

    def named_points(self) -> tuple[str, ...]:
        """Name of the centre of mass, on which the body is built."""
        return (self.center,)

    def mass_properties(self, scene: Placed) -> tuple[Any, np.ndarray, Any]:
        """Given mass, undeformed global centre of mass (2,), and given moment of inertia about it."""
        return self.mass, scene.position(self.center), self.inertia


class Rod(UniformRod, RigidBody):
    """A uniform slender rod between two points: m = density area L, inertia m L^2 / 12; it follows when a point moves."""

    kind = "rod"

    def named_points(self) -> tuple[str, ...]:
        """Names of both ends of the rod, on which the body is built."""
        return self.between

    def mass_properties(self, scene: Placed) -> tuple[Any, np.ndarray, Any]:
        """Mass, undeformed global centre of mass (2,), and moment of inertia about it, from the end points of the rod."""
        start, end = (scene.position(point) for point in self.between)
        square = (end - start) @ (end - start)
        mass = self.density * self.area * np.sqrt(square)
        return mass, (start + end) / 2, mass * square / 12
