"""A scene at one step of a solution: what configurations in the plane and in space share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from toolkit.components.bodies.model_body import ModelBody
from toolkit.components.joints.joint import AtPoint, AtPoints, Joint, JointBetweenPoints
from toolkit.components.joints.rigid_joint import Tie
from toolkit.components.loads.torque import SpatialTorque
from toolkit.components.markers.component import Component
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.units import unit
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution

T = TypeVar("T")
AT_ONE_PLACE = (AtPoint, SpatialTorque)
"""Components whose points on both bodies are at one place, or that nothing stretches between."""
POINT = 1e-6
"""Parts of the model size below which a body is a point, and two points are one."""


@dataclass(frozen=True)
class Moment(ABC):
    """One step of a solution, for drawing; every position is real and global, in the scene's unit of length."""

    solution: Solution
    step: int
    _kept: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def once(self, key: Hashable, make: Callable[[], T]) -> T:
        """Object that is made when it is first asked for under a key, and stored as long as the moment is."""
        if key not in self._kept:
            self._kept[key] = make()
        found: T = self._kept[key]
        return found

    @property
    def scene(self) -> ResolvedScene:
        """ResolvedScene that was solved."""
        return self.solution.system.scene

    @property
    def time(self) -> float:
        """Time of the step."""
        return float(self.solution.times[self.step])

    @property
    def told(self) -> str:
        """Time of the step in words, or the name of a state that belongs to no time."""
        names = self.solution.names
        return names[self.step] if names else f"t = {self.time:.4g} {unit(self.scene.units, 'time')}"

    def coordinates(self, body: str) -> np.ndarray:
        """Coordinates of one body; the ground has none."""
        return np.real(self.solution.q[self.step, self.solution.coordinates(body)])

    def flexible(self) -> list[str]:
        """Names of the flexible bodies."""
        return [name for name, body in self.scene.bodies.items() if isinstance(body, ModelBody)]

    @abstractmethod
    def position(self, body: str, point: str) -> np.ndarray:
        """Position (d,) of a named point of the scene, as carried by the body."""

    @abstractmethod
    def segments(self, body: str) -> list[np.ndarray]:
        """Lines (n, d) that a body is drawn as."""

    def rods(self, but: Collection[str] = ()) -> list[np.ndarray]:
        """Lines of all bodies, without those that are drawn in another way."""
        return [line for body in self.scene.bodies if body not in but for line in self.segments(body)]

    def ends(self, component: Component) -> np.ndarray:
        """Points at which a joint or load grips its two bodies, (2, d)."""
        return np.array([self.position(body, point) for body, point in component.grips])

    def links(self) -> list[Component]:
        """Springs and distance joints: components between two different points."""
        every = [
            each for each in self.components() if not isinstance(each, AT_ONE_PLACE) and each.grips[0][1] != each.grips[1][1]
        ]
        return [each for each in every if isinstance(each, JointBetweenPoints) or not isinstance(each, AtPoints)]

    @abstractmethod
    def across(self, joint: AtPoints, side: int) -> np.ndarray:
        """Two directions, rows (2, d), in the plane of a wheel at one of a joint's points, turning with it."""

    def wheels(self) -> list[np.ndarray]:
        """Pitch circles of gears, pinions and discs, each with a spoke that turns with it, (n, d)."""
        angles, found = np.linspace(0, 2 * np.pi, 61), []
        unit = np.column_stack([np.cos(angles), np.sin(angles)])
        for joint in (each for each in self.components() if isinstance(each, AtPoints)):
            for side, radius in joint.circles(self.scene):
                centre = self.position(*joint.grips[side])
                found.append(np.vstack([centre, centre + radius * unit @ self.across(joint, side)]))
        return found

    def named_points(self) -> dict[str, np.ndarray]:
        """Positions of the points that bodies are built on or gripped at, carried by a moving body if there is one."""
        return self.once("named points", self._named_points)

    def _named_points(self) -> dict[str, np.ndarray]:
        built_on = [(name, point) for name, body in self.scene.bodies.items() for point in body.named_points()]
        moving_first = sorted([*self.grips(), *built_on], key=lambda grip: grip[0] == "ground")
        return {point: self.position(body, point) for body, point in reversed(moving_first)}

    def bare_points(self, marked: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Named points that stand at none of the places (d,) that are marked already."""
        near = POINT * self.scene.size
        return [
            place for place in self.named_points().values() if not any(np.linalg.norm(place - each) < near for each in marked)
        ]

    def longest_piece(self, body: str) -> np.ndarray | None:
        """Ends (2, d) of a body's longest line, or of its longest piece between two named points; None without lines."""
        if not (lines := self.segments(body)):
            return None
        line = lines[first_largest(np.array([np.ptp(each, axis=0).max() for each in lines]))]
        start, along = line[0], line[-1] - line[0]
        points = np.array([*self.named_points().values()]).reshape(-1, len(start)) - start
        places = points @ along / max(float(along @ along), np.finfo(float).tiny)
        beside = np.linalg.norm(points - places[:, None] * along, axis=1) < POINT * self.scene.size
        places = np.sort(np.concatenate([[0.0, 1.0], places[beside & (places > 0) & (places < 1)]]))
        piece = first_largest(np.diff(places))
        return np.asarray(start + places[piece : piece + 2, None] * along)

    def components(self) -> list[Component]:
        """All joints and loads that grip bodies, without those that tie the parts of a cut body."""
        every = [*self.joints(), *self.scene.loads.values()]
        return [each for each in every if isinstance(each, Component)]

    def joints(self) -> list[Joint]:
        """All joints, without those that tie the parts of a cut body."""
        return [each for each in self.scene.joints.values() if not isinstance(each, Tie)]

    def grips(self) -> list[tuple[str, str]]:
        """Pairs (body, point) at which a joint or load grips, each once."""
        return list(dict.fromkeys(grip for each in self.components() for grip in each.grips))


def names_by_place(moment: Moment, tolerance: float, motion: Sequence[Moment] = ()) -> list[tuple[np.ndarray, str]]:
    """Positions of the named points; points closer together than the tolerance, at all moments of a motion, share one label."""
    every = [each.named_points() for each in motion or (moment,)]
    found: list[list[str]] = []
    for name in sorted(moment.named_points()):
        near = [names for names in found if all(np.linalg.norm(at[names[0]] - at[name]) < tolerance for at in every)]
        if near:
            near[0].append(name)
        else:
            found.append([name])
    return [(moment.named_points()[names[0]], ", ".join(names)) for names in found]
