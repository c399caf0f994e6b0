"""Curves over time of a scene in space: largest stress, motion of the points, rotation of the bodies."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.foundation.units import unit
from toolkit.render.curves import Panels, draw_panels, merged
from toolkit.render.space.body_shape import body_shape, has_shape
from toolkit.render.space.configuration import SpatialConfiguration
from toolkit.responses.stress.von_mises import point_stress
from toolkit.system.solution import Solution


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
    return [(f"stress in {unit(solution.system.scene.units, 'stress')}", curves)] if curves else []


def _motion_panels(solution: Solution, moments: list[SpatialConfiguration]) -> Panels:
    """Distance of every named point that moves from where it is undeformed."""
    start = SpatialConfiguration.undeformed(solution).named_points()
    places = [moment.named_points() for moment in moments]
    curves = {point: np.array([np.linalg.norm(place[point] - here) for place in places]) for point, here in start.items()}
    moved = {point: values for point, values in curves.items() if values.any()}
    return [(f"motion of points in {unit(solution.system.scene.units, 'length')}", merged(moved))] if moved else []


def _rotation_panels(solution: Solution, moments: list[SpatialConfiguration]) -> Panels:
    """Angle by which every frame is turned against its start, between 0 and pi."""
    start = SpatialConfiguration.undeformed(solution)
    bodies = solution.system.scene.bodies.items()
    turning = [name for name, body in bodies if body.turns and not isinstance(body, CutBody)]
    curves = {name: np.array([_angle(start.rotation(name).T @ moment.rotation(name)) for moment in moments]) for name in turning}
    return [(f"rotation in {unit(solution.system.scene.units, 'angle')}", merged(curves))] if curves else []


def _angle(rotation: np.ndarray) -> float:
    """Of a rotation matrix, from its antisymmetric part (2 sin) and its trace (1 + 2 cos)."""
    sine = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    return float(np.arctan2(np.linalg.norm(sine), np.trace(rotation) - 1))
