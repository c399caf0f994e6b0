"""A scene in the plane at one step of a solution: where its bodies and points are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.flexible import Flexible
from toolkit.bodies.rigid import Rod
from toolkit.joints.joint import AtPoints
from toolkit.kinematics.planar import rotation
from toolkit.reduced_model.model import Outline
from toolkit.render.moment import Moment
from toolkit.responses.cut_shape import whole_axes


@dataclass(frozen=True)
class Configuration(Moment):
    """One step of a planar solution, for drawing."""

    def elastic(self, body: str) -> np.ndarray:
        """Elastic coordinates q_f of a flexible body, shape (n_f,)."""
        found = self.scene.body(body)
        if isinstance(found, CutBody):
            return self.coordinates(body)[found.elastic_places]
        return self.coordinates(body)[3 if found.has_frame else 0 :]

    def place(self, body: str, points: np.ndarray) -> np.ndarray:
        """Global places r + A(theta) u of points (n, 2) in a flexible body's frame; of a cut one in the axes of the whole."""
        found = self.scene.body(body)
        if isinstance(found, CutBody):
            place, turned, origin = whole_axes(self.scene, body, self.coordinates(body))
            return np.real(place + (points - origin) @ rotation(turned).T)
        if found.has_frame:
            x, y, angle = self.coordinates(body)[:3]
        else:
            (x, y), angle = (found.position, found.angle) if isinstance(found, Flexible) else ((0.0, 0.0), 0.0)
        return np.real(np.array([x, y]) + points @ rotation(angle).T)

    def position(self, body: str, point: str) -> np.ndarray:
        """Position (2,) of a named point of the scene: r + A(theta) (z0 + Z q), or z0 + Z q without a frame."""
        found, q = self.scene.body(body), self.coordinates(body)
        marker = found.marker(self.scene, point, body)
        local = np.real(marker.point[:2] + q[marker.columns] @ marker.shape[:, :2])
        frame = marker.columns[:3]
        return q[frame[:2]] + rotation(q[frame[2]]) @ local if found.has_frame else local

    def turned(self, body: str, point: str, direction: np.ndarray) -> np.ndarray:
        """Direction (2,) of the undeformed configuration, turned with the body at a point: by theta + t0 + T q."""
        q, marker = self.coordinates(body), self.scene.body(body).marker(self.scene, point, body)
        angle = np.real(marker.point[2] + q[marker.columns] @ marker.shape[:, 2])
        return rotation(angle + q[marker.columns[2]] if self.scene.body(body).has_frame else angle) @ direction

    def across(self, joint: AtPoints, side: int) -> np.ndarray:
        """Axes of the coordinates, turned with the body."""
        return np.array([self.turned(*joint.grips[side], direction) for direction in np.eye(2)])

    def segments(self, body: str) -> list[np.ndarray]:
        """Lines (n, 2) that a body is drawn as: along a rod, or from a rigid body's centre of mass to its gripped points.

        A flexible body with a mesh is drawn as it is, without lines; else it is its outline, or a line through its interface points.
        """
        found = self.scene.body(body)
        if isinstance(found, Flexible):
            return self._chain(body, found)
        if isinstance(found, Rod):
            return [np.array([self.position(body, point) for point in found.between])]
        centre = self.coordinates(body)[:2]
        return [np.array([centre, self.position(body, point)]) for name, point in self.grips() if name == body]

    def _chain(self, body: str, found: Flexible) -> list[np.ndarray]:
        model = self.scene.model(found.model, "interfaces", "mesh", "outline")
        if model.outline:
            return [self.place(body, line @ np.append(1.0, self.elastic(body))) for line in lines_of(model.outline)]
        points = sorted((model.interfaces or {}).values(), key=lambda point: float(point.arc_length))
        if model.mesh or len(points) < 2:
            return []
        q = np.append(1.0, self.elastic(body))
        return [self.place(body, np.array([point.at(float(point.arc_length))[0] @ q for point in points]))]


def lines_of(outline: Outline) -> list[np.ndarray]:
    """Positions (n, 2, 1 + n_f) along every line of edges that follow one another."""
    first, last = outline.edges[:, 0], outline.edges[:, 2]
    starts = np.flatnonzero(np.append(True, first[1:] != last[:-1]))
    pieces = np.split(outline.edges, starts[1:])
    chains = [np.append(piece[:, :2].ravel(), piece[-1, 2]) for piece in pieces]
    return [outline.position[chain[np.append(True, np.diff(chain) != 0)]] for chain in chains]
