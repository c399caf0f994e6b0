"""What all pictures of one spatial solution share: the colours' limit, what is in view, the lengths of arrows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from toolkit.bodies.rigid import SpatialRod
from toolkit.foundation.spread import spread
from toolkit.joints.joint import SpatialJoint
from toolkit.render.readable_units import Readable, readable_stress
from toolkit.render.round_numbers import round_up
from toolkit.render.space.arrows import Arrow, arrows
from toolkit.render.space.body_shape import BodyShape, body_shape, has_shape
from toolkit.render.space.camera import ISOMETRIC
from toolkit.render.space.configuration import SpatialConfiguration
from toolkit.render.stress_told import round_off, told
from toolkit.render.view import View
from toolkit.responses.stress.von_mises import point_stress
from toolkit.system.solution import Solution

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
