"""Curves over time of a scene in space: largest stress, motion of the points, rotation of the bodies."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.render.curves import Panels, draw_panels, merged, motion_panels
from toolkit.render.space.body_shape import body_shape, has_shape
from toolkit.render.space.configuration import SpatialConfiguration
from toolkit.render.stress_told import stress_range
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
    moved = motion_panels(SpatialConfiguration.undeformed(solution).named_points(), moments)
    return draw_panels(solution, _stress_panels(solution, moments[0]) + moved + _rotation_panels(solution, moments))


def _stress_panels(solution: Solution, start: SpatialConfiguration) -> Panels:
    curves: dict[str, np.ndarray] = {}
    for body in (name for name in start.flexible() if has_shape(solution.system.scene, name)):
        low, high = stress_range(solution, body).T
        if body_shape(start, body).stress.shape[1] == 1:
            curves |= {f"{body}, largest": high, f"{body}, smallest": low}
        else:
            curves[f"{body}, largest von Mises"] = high
    return [("stress", "stress", curves)] if curves else []


def _rotation_panels(solution: Solution, moments: list[SpatialConfiguration]) -> Panels:
    """Angle by which every frame has turned about its main axis; whole turns count."""
    bodies = solution.system.scene.bodies.items()
    turning = [name for name, body in bodies if body.turns and not isinstance(body, CutBody)]
    curves = {name: counted_angle(np.array([moment.rotation(name) for moment in moments])) for name in turning}
    return [("rotation about\nown main axis", "angle", merged(curves))] if curves else []


def counted_angle(rotations: np.ndarray) -> np.ndarray:
    """Angles of frames (n, 3, 3), one after the other, about the fixed axis about which they turn most, (n,).

    The sum of all small turns phi_k (rotation vectors between neighbours) along the axis a that makes the sum of (phi_k . a)^2 largest,
    with the sign that makes the largest angle positive. A frame must turn by less than half a turn from one to the next.
    """
    small = Rotation.from_matrix(rotations[1:] @ np.swapaxes(rotations[:-1], 1, 2)).as_rotvec()
    axis = np.linalg.eigh(small.T @ small)[1][:, -1]
    angles = np.append(0.0, np.cumsum(small @ axis))
    return angles * (1.0 if angles.max() >= -angles.min() else -1.0)
