"""A scene at one step of a solution: where its bodies and points are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolkit.bodies.flexible import Flexible
from toolkit.bodies.rigid import Rod
from toolkit.component import Component
from toolkit.joints.joint import PointJoint
from toolkit.planar import rotation
from toolkit.reduced_model import Outline
from toolkit.scene import Scene
from toolkit.solution import Solution


@dataclass(frozen=True)
class Configuration:
    """One step of a solution, for drawing; every position is real and global, in the scene's unit of length."""

    solution: Solution
    step: int

    @property
    def scene(self) -> Scene:
        """What was solved."""
        return self.solution.system.scene

    @property
    def time(self) -> float:
        """Time of the step."""
        return float(self.solution.times[self.step])

    def coordinates(self, body: str) -> np.ndarray:
        """Coordinates of one body; the ground has none."""
        return np.real(self.solution.q[self.step, self.solution.coordinates(body)])

    def elastic(self, body: str) -> np.ndarray:
        """q_f of a flexible body, shape (n_f,)."""
        return self.coordinates(body)[3 if self.scene.body(body).has_frame else 0 :]

    def place(self, body: str, points: np.ndarray) -> np.ndarray:
        """Points (n, 2) given in the frame of a flexible body, r + A(theta) u."""
        found = self.scene.body(body)
        if found.has_frame:
            x, y, angle = self.coordinates(body)[:3]
        else:
            (x, y), angle = (found.position, found.angle) if isinstance(found, Flexible) else ((0.0, 0.0), 0.0)
        return np.real(np.array([x, y]) + points @ rotation(angle).T)

    def flexible(self) -> list[str]:
        """Names of the flexible bodies."""
        return [name for name, body in self.scene.bodies.items() if isinstance(body, Flexible)]

    def position(self, body: str, point: str) -> np.ndarray:
        """Where the body carries the named point of the scene: r + A(theta) (z0 + Z q), or z0 + Z q without a frame; (2,)."""
        found, q = self.scene.body(body), self.coordinates(body)
        marker = found.marker(self.scene, point, body)
        local = np.real(marker.point[:2] + q[marker.columns] @ marker.shape[:, :2])
        return q[:2] + rotation(q[2]) @ local if found.has_frame else local

    def turned(self, body: str, point: str, direction: np.ndarray) -> np.ndarray:
        """A direction (2,) of the undeformed configuration that turns with the body at a point: by theta + t0 + T q."""
        q, marker = self.coordinates(body), self.scene.body(body).marker(self.scene, point, body)
        angle = np.real(marker.point[2] + q[marker.columns] @ marker.shape[:, 2])
        return rotation(angle + q[2] if self.scene.body(body).has_frame else angle) @ direction

    def ends(self, component: Component) -> np.ndarray:
        """Points at which a joint or load grips its two bodies, (2, 2)."""
        return np.array([self.position(body, point) for body, point in component.grips])

    def links(self) -> list[Component]:
        """Springs and distance joints: components between two different points."""
        return [each for each in self._components() if not isinstance(each, PointJoint) and each.grips[0][1] != each.grips[1][1]]

    def segments(self, body: str) -> list[np.ndarray]:
        """Lines that stand for a body, each (n, 2): along a rod, or from the centre of mass of a rigid body to every gripped point.

        A flexible body with a mesh is drawn as it is, without lines; else it is its outline, or a line through its interface points.
        """
        found = self.scene.body(body)
        if isinstance(found, Flexible):
            return self._chain(body, found)
        if isinstance(found, Rod):
            return [np.array([self.position(body, point) for point in found.between])]
        centre = self.coordinates(body)[:2]
        return [np.array([centre, self.position(body, point)]) for name, point in self._grips() if name == body]

    def _chain(self, body: str, found: Flexible) -> list[np.ndarray]:
        model = self.scene.model(found.model, "interfaces", "mesh", "outline")
        if model.outline:
            return [self.place(body, line @ np.append(1.0, self.elastic(body))) for line in lines_of(model.outline)]
        points = sorted((model.interfaces or {}).values(), key=lambda point: float(point.arc_length))
        if model.mesh or len(points) < 2:
            return []
        q = np.append(1.0, self.elastic(body))
        return [self.place(body, np.array([point.at(float(point.arc_length))[0] @ q for point in points]))]

    def named_points(self) -> dict[str, np.ndarray]:
        """The points that bodies are built on or gripped at, each where a moving body carries it, else where the ground does."""
        built_on = [(name, point) for name, body in self.scene.bodies.items() for point in body.named_points()]
        moving_first = sorted([*self._grips(), *built_on], key=lambda grip: grip[0] == "ground")
        return {point: self.position(body, point) for body, point in reversed(moving_first)}

    def _components(self) -> list[Component]:
        every = [*self.scene.joints.values(), *self.scene.loads.values()]
        return [each for each in every if isinstance(each, Component)]

    def _grips(self) -> list[tuple[str, str]]:
        return list(dict.fromkeys(grip for each in self._components() for grip in each.grips))


def names_by_place(configuration: Configuration, tolerance: float) -> list[tuple[np.ndarray, str]]:
    """Positions of the named points; points closer together than the tolerance share one label."""
    found: list[tuple[np.ndarray, list[str]]] = []
    for name, here in sorted(configuration.named_points().items()):
        near = [names for place, names in found if np.hypot(*(place - here)) < tolerance]
        if near:
            near[0].append(name)
        else:
            found.append((here, [name]))
    return [(place, ", ".join(names)) for place, names in found]


def lines_of(outline: Outline) -> list[np.ndarray]:
    """Positions (n, 2, 1 + n_f) along every line of edges that follow one another."""
    first, last = outline.edges[:, 0], outline.edges[:, 2]
    starts = np.flatnonzero(np.append(True, first[1:] != last[:-1]))
    pieces = np.split(outline.edges, starts[1:])
    chains = [np.append(piece[:, :2].ravel(), piece[-1, 2]) for piece in pieces]
    return [outline.position[chain[np.append(True, np.diff(chain) != 0)]] for chain in chains]
