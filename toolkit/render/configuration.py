"""A scene at one step of a solution: where its bodies and points are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolkit.bodies.flexible import Flexible
from toolkit.bodies.rigid import Rod
from toolkit.component import Component
from toolkit.planar import rotation
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

    def position(self, body: str, point: str) -> np.ndarray:
        """Where the body carries the named point of the scene: r + A(theta) (z0 + Z q), or z0 + Z q without a frame; (2,)."""
        found, q = self.scene.body(body), self.coordinates(body)
        marker = found.marker(self.scene, point, body)
        local = np.real(marker.point[:2] + q[marker.columns] @ marker.shape[:, :2])
        return q[:2] + rotation(q[2]) @ local if found.has_frame else local

    def joint_points(self) -> dict[str, np.ndarray]:
        """Points of every joint on its two bodies, each (2, 2)."""
        return {name: self._points(joint) for name, joint in self.scene.joints.items()}

    def links(self) -> list[np.ndarray]:
        """Lines of springs and distance joints: components between two different points, each (2, 2)."""
        return [self._points(each) for each in self._between_points()]

    def segments(self, body: str) -> list[np.ndarray]:
        """Straight lines that stand for a rigid body, each (2, 2): along a rod, or from the centre of mass to every gripped point."""
        found = self.scene.body(body)
        if not found.has_frame or isinstance(found, Flexible):
            return []
        if isinstance(found, Rod):
            return [np.array([self.position(body, point) for point in found.between])]
        centre = self.coordinates(body)[:2]
        return [np.array([centre, self.position(body, point)]) for point in grip_points(self.scene, body)]

    def ground_points(self) -> list[np.ndarray]:
        """Points of the ground that joints and springs hold on to."""
        held = [grip for each in [*self.scene.joints.values(), *self._between_points()] for grip in each.grips]
        return [self.position("ground", point) for point in dict.fromkeys(point for body, point in held if body == "ground")]

    def _between_points(self) -> list[Component]:
        every = [*self.scene.joints.values(), *self.scene.loads.values()]
        return [each for each in every if isinstance(each, Component) and each.grips[0][1] != each.grips[1][1]]

    def _points(self, component: Component) -> np.ndarray:
        return np.array([self.position(body, point) for body, point in component.grips])


def grip_points(scene: Scene, body: str) -> list[str]:
    """Names of the points at which joints and loads grip a body."""
    components = [*scene.joints.values(), *scene.loads.values()]
    grips = [grip for each in components if isinstance(each, Component) for grip in each.grips]
    return list(dict.fromkeys(point for name, point in grips if name == body))


def joints_by_place(configuration: Configuration, tolerance: float) -> list[tuple[np.ndarray, str]]:
    """Positions of the joints with their names; joints closer together than the tolerance share one label."""
    found: list[tuple[np.ndarray, list[str]]] = []
    for name, (here, _) in configuration.joint_points().items():
        near = [names for place, names in found if np.hypot(*(place - here)) < tolerance]
        if near:
            near[0].append(name)
        else:
            found.append((here, [name]))
    return [(place, ", ".join(names)) for place, names in found]
