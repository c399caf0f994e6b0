"""Curves over time: extreme stress, distance to the target shape, rotations of the rigid bodies; motion of points where nothing turns."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.flexible import Flexible
from toolkit.render.curves import SEEN, Panels, draw_panels, merged, motion_panels
from toolkit.render.plane.configuration import Configuration
from toolkit.render.stress_told import stress_range
from toolkit.responses.shape_error import gaps
from toolkit.system.flexible_bodies import flexible_body
from toolkit.system.solution import Solution


def shape_errors(solution: Solution, body: str, steps: slice = slice(None)) -> np.ndarray | None:
    """Distance of every node to its target at every time, shape (n_t, n_k); None if the body has no target."""
    scene = solution.system.scene
    shape = scene.model(flexible_body(scene, body).model, "shape").shape
    if shape is None:
        return None
    return np.linalg.norm(np.real(gaps(solution, body, steps)[0]), axis=2)


def curves_figure(solution: Solution) -> Figure:
    """The curves, a panel per quantity."""
    return draw_panels(solution, _stress_panels(solution) + _shape_panels(solution) + _rotation_panels(solution))


def _flexible(solution: Solution) -> list[str]:
    return [name for name, body in solution.system.scene.bodies.items() if isinstance(body, Flexible)]


def _stress_panels(solution: Solution) -> Panels:
    curves: dict[str, Any] = {}
    for body in _flexible(solution):
        low, high = stress_range(solution, body).T
        curves |= {f"{body}, largest": high, f"{body}, smallest": low}
    return [("stress", "stress", curves)] if curves else []


def _shape_panels(solution: Solution) -> Panels:
    curves: dict[str, Any] = {}
    for body in _flexible(solution):
        errors = shape_errors(solution, body)
        if errors is not None:
            curves |= {f"{body}, largest": errors.max(axis=1), f"{body}, RMS": np.sqrt((errors**2).mean(axis=1))}
    return [("distance to target", "length", curves)] if curves else []


def _rotation_panels(solution: Solution) -> Panels:
    scene = solution.system.scene
    framed = [name for name, body in scene.bodies.items() if body.has_frame and not isinstance(body, CutBody)]
    curves = {name: np.real(solution.q[:, solution.coordinates(name).start + 2]) for name in framed}
    rotations: Panels = [("rotation", "angle", merged(curves))] if curves else []
    turned = any(np.abs(angle).max() > SEEN for angle in curves.values())
    return rotations if turned or not curves else _motion_panels(solution) or rotations


def _motion_panels(solution: Solution) -> Panels:
    moments = [Configuration(solution, step) for step in range(len(solution.times))]
    scene, points = solution.system.scene, moments[0].named_points()
    return motion_panels({point: np.real(scene.position(point)) for point in points}, moments)
