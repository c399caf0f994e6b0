"""What all pictures of one spatial solution share: the colours' limit, what is in view, the lengths of arrows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.components.bodies.rigid import SpatialRod
from toolkit.components.curves.curve import Curve
from toolkit.components.joints.joint import SpatialJoint
from toolkit.components.loads.point_force import SpatialPointForce
from toolkit.components.loads.pressure import Pressure
from toolkit.components.loads.torque import SpatialTorque
from toolkit.components.markers.component import Component
from toolkit.foundation.near_ties import spread
from toolkit.render.readable_units import Readable, View, readable_stress, round_off, round_up, told
from toolkit.render.space.configuration import BodyShape, SpatialConfiguration, body_shape, has_shape
from toolkit.responses.stress import point_stress
from toolkit.system.solution import Solution

ANGLE = np.deg2rad(25.0)
"""Angle of view from the lower to the upper edge of a picture in perspective."""
ISOMETRIC = np.array([[1.0, 1.0, 0.0], [-1.0, 1.0, 2.0], [1.0, -1.0, 1.0]]) / np.sqrt([[2.0], [6.0], [3.0]])
"""Directions to the right, up and towards the eye: x comes to the front on the right, y goes to the back on the right, z is up."""
_LEAST = 0.25
"""Half of what is seen at least, relative to the reach: of a rod along the line of sight."""
_CLEAR = 2.2
"""Distance by which things are moved before or behind all others, relative to the reach; these are at most two apart."""


@dataclass(frozen=True)
class Camera:
    """An isometric view of a box of points.

    Attributes
    ----------
    focus
        What it looks at, (3,).
    size
        Width and height of what it sees at the focus, (2,), in the scene's unit of length.
    distance
        From the eye to the focus.
    reach
        How far things are from the focus at most.
    perspective
        Whether what is nearer is larger.
    """

    focus: np.ndarray
    size: np.ndarray
    distance: float
    reach: float
    perspective: bool

    @classmethod
    def framing(cls, points: np.ndarray, aspect: float, margin: float, perspective: bool) -> Camera:
        """Nearest view of an aspect (width over height) that shows all points (n, 3), with a margin relative to their extent."""
        seen = points @ ISOMETRIC.T
        reach = 0.6 * float(np.linalg.norm(np.ptp(seen, axis=0))) or 0.5
        middle = (seen.min(axis=0) + seen.max(axis=0)) / 2
        seen = np.vstack([seen, middle + _LEAST * reach * np.vstack([np.eye(3), -np.eye(3)])])
        size = _framed(np.ptp(seen[:, :2], axis=0), aspect, margin)
        if not perspective:
            return cls(middle @ ISOMETRIC, size, 5 * reach, reach, False)
        beside, height = np.abs(seen - middle), np.tan(ANGLE / 2)
        need = np.maximum(beside[:, 0] / aspect, beside[:, 1]) * (1 + 2 * margin) / height
        distance = max(float(np.max(seen[:, 2] - middle[2] + need)), 1.5 * reach)
        return cls(middle @ ISOMETRIC, 2 * distance * height * np.array([aspect, 1.0]), distance, reach, True)

    @property
    def eye(self) -> np.ndarray:
        """Position of the camera, (3,)."""
        return self.focus + self.distance * ISOMETRIC[2]

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Places (..., 2) of points (..., 3) on the plane through the focus, from the lower left corner of the view."""
        local = (points - self.focus) @ ISOMETRIC.T
        nearness = self.distance / (self.distance - local[..., 2:]) if self.perspective else 1.0
        return local[..., :2] * nearness + self.size / 2

    def nearer(self, points: np.ndarray, shift: float) -> np.ndarray:
        """Points (n, 3) moved towards the eye by about a length, without a change of where they are seen."""
        return self._along_sight(points, shift, 1 - shift / self.distance)

    def before_all(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) moved before everything else, without a change of where they are seen."""
        return self._along_sight(points, _CLEAR * self.reach, self._nearest / self._farthest)

    def behind_all(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) moved behind everything else, without a change of where they are seen."""
        return self._along_sight(points, -_CLEAR * self.reach, self._farthest / self._nearest)

    @property
    def range(self) -> tuple[float, float]:
        """Distances from the eye that contain everything, also what was moved before and behind all else."""
        if self.perspective:
            return 0.9 * self._nearest**2 / self._farthest, 1.1 * self._farthest**2 / self._nearest
        return self._nearest - _CLEAR * self.reach, self._farthest + _CLEAR * self.reach

    @property
    def _nearest(self) -> float:
        return self.distance - self.reach

    @property
    def _farthest(self) -> float:
        return self.distance + self.reach

    def _along_sight(self, points: np.ndarray, shift: float, factor: float) -> np.ndarray:
        """Points moved by a length in parallel projection, in perspective to a multiple of their distance from the eye."""
        return self.eye + (points - self.eye) * factor if self.perspective else points + shift * ISOMETRIC[2]


def natural_aspect(points: np.ndarray, least: float, largest: float) -> float:
    """Width over height of the view of points (n, 3), within bounds, so that a panel is empty at no side."""
    width, height = np.ptp(points @ ISOMETRIC[:2].T, axis=0)
    return float(np.clip(width / height if height else largest, least, largest))


def _framed(extent: np.ndarray, aspect: float, margin: float) -> np.ndarray:
    """Width and height (2,) of the smallest rectangle of an aspect round an extent (2,), with a margin relative to that."""
    size = extent + 2 * margin * max(extent.max(), 1e-12)
    return np.maximum(size, [size[1] * aspect, size[0] / aspect])


_CLOSED = 1e-12
"""Square of a pressure's resultant that is round-off, relative to that of its moments over the model size."""


class Arrow(NamedTuple):
    """Vector at a point, in the scene's units of force or torque."""

    kind: str  # "force" or "torque"
    point: np.ndarray  # (3,)
    vector: np.ndarray  # (3,)


def arrows(moment: SpatialConfiguration) -> list[Arrow]:
    """Arrows of all loads that are forces or torques, the reaction of a torque and the resultant of a pressure included."""
    found = []
    for load in moment.scene.loads.values():
        if isinstance(load, SpatialPointForce):
            found.append(Arrow("force", moment.ends(load)[0], _turned(moment, load, load.force, load.frame)))
        elif isinstance(load, SpatialTorque):
            torque = _turned(moment, load, load.torque, load.frame)
            one, other = moment.ends(load)
            found.append(Arrow("torque", one, torque))
            if load.reaction != "ground":
                found.append(Arrow("torque", other, -torque))
        elif isinstance(load, Pressure):
            found += _resultant(moment, load)
    return found


def _resultant(moment: SpatialConfiguration, load: Pressure) -> list[Arrow]:
    """Resultant force of a pressure; on a cut body the sum over its parts, at their weighted mean point."""
    found = [
        arrow
        for piece in moment.scene.pieces([load.body])
        for arrow in _on_piece(moment, load.model_copy(update={"body": piece}))
    ]
    if len(found) < 2:
        return found
    weights = [float(np.linalg.norm(each.vector)) for each in found]
    point = np.average([each.point for each in found], axis=0, weights=weights) if any(weights) else found[0].point
    return [Arrow("force", point, np.sum([each.vector for each in found], axis=0))]


def _on_piece(moment: SpatialConfiguration, load: Pressure) -> list[Arrow]:
    """Force f of a pressure on a flat surface, at c_b = f_a L[a, b] [1; q_f] / (f . f); empty if closed."""
    body = moment.spatial_body(load.body)
    assert isinstance(body, SpatialFlexible)
    numbers = load.numbers_on(moment.scene, body)
    f, shares = np.real(numbers.force), np.real(numbers.moment).reshape(-1, 3, 3)
    if f @ f <= _CLOSED * np.abs(shares[0]).max() ** 2 / moment.scene.size**2:
        return []
    centre = np.einsum("a,jab,j->b", f, shares, np.append(1.0, moment.elastic(load.body))) / (f @ f)
    local = centre if body.frame == "moving" else body.placement.T @ centre
    return [
        Arrow("force", moment.place(load.body, local[None])[0], _factor(load.curve, moment.time) * moment.rotation(load.body) @ f)
    ]


def _turned(moment: SpatialConfiguration, load: Component, vector: tuple, frame: str) -> np.ndarray:
    """Vector of a load at the time of the moment, in global axes."""
    axes = moment.turned(*load.grips[0], np.eye(3)) if frame == "body" else np.eye(3)
    return _factor(load.time_curve, moment.time) * axes @ np.real(np.array(vector))


def _factor(curve: Curve | None, time: float) -> float:
    return 1.0 if curve is None else float(np.real(curve.evaluate(np.array([time]))[0, 0]))


MOST_MOMENTS = 60
"""Number of moments of the whole motion that are looked at for the view and for the largest stress."""
SOME = 50
"""Points of a surface that stand for it where moments are compared."""
TUBE, ARROW = 1 / 180, 1 / 7
"""Radius of a tube and length of the longest arrow, relative to the extent of the scene."""


@dataclass(frozen=True)
class SpatialLook:
    """Choices that all pictures of one spatial solution share.

    Attributes
    ----------
    bodies
        Flexible bodies that have a surface.
    signed
        Whether the stress of fibres is shown with its sign; with a solid in the scene all is von Mises stress.
    stress_limit
        The largest stress, rounded up; zero if there is none to show.
    points
        What has to be in view, (n, 3).
    largest
        "force" and "torque" -> the largest one, which has the longest arrow.
    view
        How it is looked at.
    units
        System of units of the scene.
    """

    bodies: tuple[str, ...]
    signed: bool
    stress_limit: float
    points: np.ndarray
    largest: dict[str, float]
    view: View
    units: str

    @property
    def extent(self) -> float:
        """Size of the drawing, which decides the sizes of tubes and symbols."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0))) or 1.0

    @property
    def radius(self) -> float:
        """Radius of a tube that is drawn."""
        return TUBE * self.extent

    @property
    def stress_name(self) -> str:
        """Name of the stress that the colours show."""
        return "stress" if self.signed else "von Mises stress"

    @property
    def shown_stress(self) -> Readable:
        """Unit in which stresses are written."""
        return readable_stress(self.stress_limit, self.units)

    def colored(self, shape: BodyShape) -> np.ndarray:
        """Stress that is shown at the points of a shape, in the unit in which it is written, (n,)."""
        stress = self.shown_stress.factor * point_stress(shape.stress)
        return stress if self.signed else np.abs(stress)


def choose_spatial_look(solution: Solution, steps: Sequence[int], view: View) -> SpatialLook:
    """Look of the pictures at the given steps, wide enough for the whole motion."""
    scene, start = solution.system.scene, SpatialConfiguration.undeformed(solution)
    bodies = tuple(name for name in start.flexible() if has_shape(scene, name))
    points, limit, loads = [drawn_points(start)], 0.0, list[Arrow]()
    for step in sorted({*spread(solution.steps, MOST_MOMENTS), *steps}):
        moment = SpatialConfiguration(solution, step)
        points.append(drawn_points(moment))
        loads += arrows(moment)
        for body in bodies:
            shape = body_shape(moment, body)
            points.append(outermost(shape.points))
            limit = max(limit, told(point_stress(shape.stress), round_off(scene, body)))
    points += [outermost(body_shape(start, body).points) for body in bodies]
    signed = all(body_shape(start, body).stress.shape[1] == 1 for body in bodies)
    every = np.vstack(points)
    every = every if len(every) else np.zeros((1, 3))
    largest = {
        kind: max((float(np.linalg.norm(a.vector)) for a in loads if a.kind == kind), default=0.0) for kind in ("force", "torque")
    }
    size = ARROW * float(np.linalg.norm(np.ptp(every, axis=0)))
    tips = [a.point + size * a.vector / largest[a.kind] for a in loads if largest[a.kind]]
    return SpatialLook(bodies, signed, round_up(limit), np.vstack([every, *tips]), largest, view, scene.units)


def outermost(points: np.ndarray) -> np.ndarray:
    """Points that are furthest to every side as the camera sees it, and between these sides, for all of a fine mesh."""
    corners = np.array(np.meshgrid(*[(-1, 0, 1)] * 3)).reshape(3, -1).T
    return points[np.unique(np.argmax(points @ (corners @ ISOMETRIC).T, axis=0))]


def drawn_points(moment: SpatialConfiguration) -> np.ndarray:
    """Positions (n, 3) of rigid bodies, joints and links at one moment."""
    joints = [joint for joint in moment.scene.joints.values() if isinstance(joint, SpatialJoint)]
    found = [*moment.rods(), *moment.wheels(), *(moment.ends(each) for each in [*joints, *moment.links()])]
    return np.vstack([np.zeros((0, 3)), *found])


def seen_points(moment: SpatialConfiguration) -> np.ndarray:
    """Positions of rigid bodies, joints, links and some points of every flexible body's surface, the same at every moment."""
    surfaces = [body_shape(moment, body).points for body in moment.flexible() if has_shape(moment.scene, body)]
    return np.vstack([drawn_points(moment), *(points[:: 1 + len(points) // SOME] for points in surfaces)])


def rod_radius(moment: SpatialConfiguration, body: str, least: float) -> float:
    """Radius of the cylinder that a rigid body is drawn as: a rod's own, where that can be seen."""
    found = moment.scene.body(body)
    return max(least, float(np.sqrt(np.real(found.area) / np.pi))) if isinstance(found, SpatialRod) else least
