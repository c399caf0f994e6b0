"""A scene in space at one step of a solution: where its bodies, points and axes are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from toolkit.bodies.body import SpatialBody, SpatialMarkerNumbers
from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.flexible import SpatialFlexible
from toolkit.bodies.rigid import SpatialRigidBody, SpatialRod
from toolkit.joints.joint import AtPoints, SpatialJoint
from toolkit.kinematics.spatial import matrix_of, quaternion_of
from toolkit.render.moment import Moment
from toolkit.system.solution import Solution

FAR = 1e-9
"""Distance from its centre of mass below which a body is gripped there, relative to its radius of gyration."""

BOX_EDGES = 12


@dataclass(frozen=True)
class SpatialConfiguration(Moment):
    """One step of a spatial solution, for drawing."""

    @classmethod
    def undeformed(cls, solution: Solution) -> SpatialConfiguration:
        """Configuration of all bodies before anything has moved."""
        system = solution.system
        return cls(replace(solution, q=np.real(system.undeformed()[0][None, : system.n_q]), times=solution.times[:1]), 0)

    def spatial_body(self, body: str) -> SpatialBody:
        """Body of the given name."""
        found = self.scene.body(body)
        assert isinstance(found, SpatialBody)
        return found

    def elastic(self, body: str) -> np.ndarray:
        """Elastic coordinates q_f of a flexible body, shape (n_f,); of a cut one those of all its parts."""
        found = self.spatial_body(body)
        if isinstance(found, CutBody):
            return self.coordinates(body)[found.elastic_places]
        return self.coordinates(body)[found.frame_size :]

    def rotation(self, body: str) -> np.ndarray:
        """Rotation matrix A (3, 3) of the body's frame; the unit matrix without orientation coordinates."""
        found, q = self.spatial_body(body), self.coordinates(body)
        if found.turns == 4:
            return matrix_of(q[found.moves : found.moves + 4])
        if found.turns == 1:
            return matrix_of(quaternion_of(q[found.moves] * found.unit_axis))
        return np.eye(3)

    def place(self, body: str, points: np.ndarray) -> np.ndarray:
        """Global places of points (n, 3) given in the axes of a flexible body's reduced model, r + A u."""
        found = self.spatial_body(body)
        assert isinstance(found, SpatialFlexible)
        origin = self.coordinates(body)[:3] if found.moves else np.array(found.position)
        axes = self.rotation(body) @ (np.eye(3) if found.turns == 4 else found.placement)
        return np.real(origin + points @ axes.T)

    def position(self, body: str, point: str) -> np.ndarray:
        """Position (3,) of a named point of the scene, as carried by the body: r + A (z0 + Z c)."""
        body = self.scene.piece(body, point)
        marker, c = self._marker(body, point)
        return self._carried(body, np.real(marker.point[:3] + c @ marker.shape[:, :3]), np.real(marker.point[12:15]))

    def turned(self, body: str, point: str, axes: np.ndarray) -> np.ndarray:
        """Directions (3, n), columns, of the undeformed configuration that turn with the body at a point: A R(T c) e."""
        body = self.scene.piece(body, point)
        marker, c = self._marker(body, point, axes)
        return (
            self.rotation(body)
            @ matrix_of(quaternion_of(np.real(c @ marker.shape[:, 3:])))
            @ np.real(marker.point[3:12]).reshape(3, 3).T
        )

    def across(self, joint: AtPoints, side: int) -> np.ndarray:
        """First two axes of the joint, turned with the body."""
        axes = joint.axes if isinstance(joint, SpatialJoint) and joint.axes is not None else np.eye(3)
        return self.turned(*joint.grips[side], np.real(axes))[:, :2].T

    def centre(self, body: str) -> np.ndarray:
        """Centre of mass of a rigid body, (3,)."""
        found = self.spatial_body(body)
        assert isinstance(found, SpatialRigidBody)
        origin, middle = np.real(found.frame_origin(self.scene)), np.real(found.mass_properties(self.scene)[1])
        if not found.frame_size:
            return middle
        return self._carried(body, middle - origin, 0 * origin if found.moves else origin)

    def has_ball(self, body: str) -> bool:
        """Whether a ball is drawn for the centre of mass of a body."""
        found = self.spatial_body(body)
        return isinstance(found, SpatialRigidBody) and not isinstance(found, SpatialRod) and bool(self.segments(body))

    def frame(self, body: str) -> tuple[np.ndarray, np.ndarray]:
        """Origin (3,) and axes (3, 3), as columns, of the body's frame."""
        found = self.spatial_body(body)
        if isinstance(found, SpatialFlexible):
            origin, *ends = self.place(body, np.vstack([np.zeros(3), np.eye(3)]))
            return origin, np.array(ends).T - origin[:, None]
        return self.centre(body), self.rotation(body)

    def segments(self, body: str) -> list[np.ndarray]:
        """Lines (2, 3) that a rigid body is drawn as: along a rod, else from the centre of mass to every gripped point.

        A body that is gripped nowhere else is shown by the edges of the uniform box that has its mass and inertia, a flexible body
        without a surface by lines from the middle of its interface points to each.
        """
        found = self.spatial_body(body)
        if isinstance(found, SpatialFlexible):
            return self._interface_star(body, found)
        if not isinstance(found, SpatialRigidBody):
            return []
        if isinstance(found, SpatialRod):
            return [np.array([self.position(body, point) for point in found.between])]
        centre, points = self.centre(body), [*self.grips(), *((body, point) for point in found.named_points())]
        ends = [self.position(name, point) for name, point in dict.fromkeys(points) if name == body]
        arms = [
            np.array([centre, end]) for end in ends if np.linalg.norm(end - centre) > FAR * found.radius_of_gyration(self.scene)
        ]
        return arms or self._box(body, found)

    def _interface_star(self, body: str, found: SpatialFlexible) -> list[np.ndarray]:
        model, q = self.scene.model(found.model, "surface"), np.append(1.0, self.elastic(body))
        if model.surface is not None or not model.interfaces:
            return []
        points = self.place(body, np.array([point.here[0] @ q for point in model.interfaces.values()]))
        return [np.array([points.mean(axis=0), point]) for point in points]

    def _box(self, body: str, found: SpatialRigidBody) -> list[np.ndarray]:
        """Edges of a box along the principal axes, whose half sides are sqrt(3 s / m) for the second moments s."""
        mass, _, moments = found.mass_properties(self.scene)
        s, axes = np.linalg.eigh(np.real(moments))
        half, axes = np.sqrt(3 * s.clip(0) / np.real(mass)), self.rotation(body) @ axes
        corners = {signs: self.centre(body) + axes @ (half * signs) for signs in product((-1, 1), repeat=3)}
        pairs = [(a, b) for a in corners for b in corners if a < b and np.abs(np.subtract(a, b)).sum() == 2]
        return [np.array([corners[a], corners[b]]) for a, b in pairs]

    def _marker(self, body: str, point: str, axes: np.ndarray | None = None) -> tuple[SpatialMarkerNumbers, np.ndarray]:
        """Marker of a body at a point, and its coordinates c."""
        marker = self.spatial_body(body).marker(self.scene, point, body, axes)
        return marker, self.coordinates(body)[marker.columns]

    def _carried(self, body: str, local: np.ndarray, fixed: np.ndarray) -> np.ndarray:
        """Position r + A u, where r of a frame without an origin of its own is a fixed point."""
        origin = self.coordinates(body)[:3] if self.spatial_body(body).moves else fixed
        return origin + self.rotation(body) @ local
