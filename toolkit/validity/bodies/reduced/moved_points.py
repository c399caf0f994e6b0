"""Responses that look at where a point moves or turns to which a reduced body carries, and at nothing else that could hold it.

Carried are interface points of a grounded body, and rigid bodies that are fixed at one of them. Where joints hold the body elsewhere, they
bear another part of the forces as soon as it yields more; of such a body nothing is told.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from toolkit.bodies.model_body import ModelBody
from toolkit.description.point import BodyPoint
from toolkit.kinematics.spatial import axes_along
from toolkit.responses.motion import Displacement, Rotation
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import flexible_body
from toolkit.system.solution import Solution


class MovedPoint(NamedTuple):
    """What a response looks at, and what carries it."""

    response: Any  # a displacement or rotation
    body: str  # flexible
    interface: str

    def missed(self, solution: Solution, moves: np.ndarray, instants: np.ndarray) -> np.ndarray:
        """What a displacement and rotation of the interface point (n_t, 3 or 6) in the axes of the model adds, (n_t,)."""
        scene, d = solution.system.scene, solution.system.scene.dimension
        written: Any = flexible_body(scene, self.body)
        axes = written.poses(np.real(solution.q[instants][:, solution.coordinates(self.body)]))[1]
        shift, turn = np.einsum("tij,tj->ti", axes, moves[:, :d]), moves[:, d:]
        turn = np.einsum("tij,tj->ti", axes, turn) if d == 3 else turn
        if isinstance(self.response, Rotation):
            along = np.ones(1) if d == 2 else axes_along(np.array(self.response.axis))[:, 2]
            found: np.ndarray = turn @ along
            return found
        return self._along(shift)

    def _along(self, shift: np.ndarray) -> np.ndarray:
        if self.response.component == "magnitude":
            length: np.ndarray = np.linalg.norm(shift, axis=1)
            return length
        component: np.ndarray = shift[:, "xyz".index(self.response.component)]
        return component


def moved_points(scene: Scene) -> Iterator[tuple[str, MovedPoint]]:
    """Responses of this kind by name."""
    for name, response in scene.responses.items():
        if isinstance(response, Displacement | Rotation):
            ((body, point),) = response.grips(scene)
            turns = isinstance(response, Rotation)
            for carrier, at in [(body, point), *(_fixed_to(scene, body) if turns else ())]:
                place = scene.points.get(at)
                if isinstance(place, BodyPoint) and place.body == carrier and _carries_alone(scene, carrier):
                    yield name, MovedPoint(response, carrier, place.interface)


def _fixed_to(scene: Scene, body: str) -> Iterator[tuple[str, str]]:
    """The body and the point that a rigid body is fixed to, if one joint holds it."""
    mine = [joint for joint in scene.joints.values() if body in joint.bodies]
    if len(mine) == 1 and mine[0].kind == "rigid":
        yield from (grip for grip in mine[0].grips if grip[0] != body)


def _carries_alone(scene: Scene, body: str) -> bool:
    """Whether a grounded flexible body has no joints but with bodies that nothing else holds."""
    written = scene.bodies.get(body)
    if not isinstance(written, ModelBody) or written.frame_size:
        return False
    others = [other for joint in scene.joints.values() if body in joint.bodies for other in joint.bodies if other != body]
    return all(other in scene.bodies and sum(other in joint.bodies for joint in scene.joints.values()) == 1 for other in others)
