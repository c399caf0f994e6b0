"""Curves over time of a scene in space: largest stress, motion of the points, rotation of the bodies."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from toolkit.render.curves import Panels, draw_panels, merged
from toolkit.render.space.body_shape import body_shape, has_shape
from toolkit.render.space.configuration import SpatialConfiguration
from toolkit.responses.stress.von_mises import point_stress
from toolkit.system.solution import Solution

_NO_TURN = 1e-9
"""Angle below which a rotation has no axis of its own."""


def stress_extremes(moment: SpatialConfiguration, body: str) -> tuple[float, float]:
    """Smallest and largest stress of fibres, or zero and the largest von Mises stress, of a body with a surface."""
    values = point_stress(body_shape(moment, body).stress)
    values = values[np.isfinite(values)]
    return float(values.min(initial=0)), float(values.max(initial=0))


def spatial_curves_figure(solution: Solution) -> Figure:
    """The curves, a panel per quantity."""
    moments = [SpatialConfiguration(solution, step) for step in range(len(solution.times))]
    panels = _stress_panels(solution, moments) + _motion_panels(solution, moments) + _rotation_panels(solution, moments)
    return draw_panels(solution, panels)


def _stress_panels(solution: Solution, moments: list[SpatialConfiguration]) -> Panels:
    curves: dict[str, np.ndarray] = {}
    for body in (name for name in moments[0].flexible() if has_shape(solution.system.scene, name)):
        low, high = np.array([stress_extremes(moment, body) for moment in moments]).T
        if body_shape(moments[0], body).stress.shape[1] == 1:
            curves |= {f"{body}, largest": high, f"{body}, smallest": low}
        else:
            curves[f"{body}, largest von Mises"] = high
    return [("stress", "stress", curves)] if curves else []


def _motion_panels(solution: Solution, moments: list[SpatialConfiguration]) -> Panels:
    """Distance of every named point that moves from where it is undeformed."""
    start = SpatialConfiguration.undeformed(solution).named_points()
    places = [moment.named_points() for moment in moments]
    curves = {point: np.array([np.linalg.norm(place[point] - here) for place in places]) for point, here in start.items()}
    moved = {point: values for point, values in curves.items() if values.any()}
    return [("motion of points", "length", merged(moved))] if moved else []


def _rotation_panels(solution: Solution, moments: list[SpatialConfiguration]) -> Panels:
    """Angle by which every frame is turned against its start; whole turns count."""
    start = SpatialConfiguration.undeformed(solution)
    turning = [name for name in solution.system.scene.bodies if moments[0].spatial_body(name).turns]
    curves = {
        name: counted_angle(np.array([start.rotation(name).T @ moment.rotation(name) for moment in moments])) for name in turning
    }
    return [("rotation", "angle", merged(curves))] if curves else []


def counted_angle(rotations: np.ndarray) -> np.ndarray:
    """Angles of rotations (n, 3, 3) that follow one another, with whole turns, (n,).

    A rotation by theta about the axis a is also one by theta + 2 pi k: of these (theta + 2 pi k) a the one nearest to the last is taken.
    """
    last, found = np.zeros(3), []
    for vector in Rotation.from_matrix(rotations).as_rotvec():
        angle = np.linalg.norm(vector)
        axis = vector / angle if angle > _NO_TURN else last / (np.linalg.norm(last) or 1.0)
        last = (angle + 2 * np.pi * np.round((last @ axis - angle) / (2 * np.pi))) * axis
        found.append(np.linalg.norm(last))
    return np.array(found)
