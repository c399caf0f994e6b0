"""Curves over time: extreme stress, distance to the target shape, rotations of the rigid bodies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from toolkit.bodies.planar.flexible import Flexible
from toolkit.foundation.units import unit
from toolkit.render.settings import drawing_settings
from toolkit.responses.stress.stress import stress_components
from toolkit.responses.stress.von_mises import point_stress
from toolkit.system.flexible_bodies import elastic_coordinates, flexible_body
from toolkit.system.solution import Solution


def stress_range(solution: Solution, body: str) -> np.ndarray:
    """Smallest and largest stress of a flexible body at every time, shape (n_t, 2)."""
    q = np.real(solution.q[:, elastic_coordinates(solution, body)])
    stress = point_stress(np.real(stress_components(solution.system.scene, body, q)))
    return np.column_stack([stress.min(axis=1, initial=0), stress.max(axis=1, initial=0)])


def shape_errors(solution: Solution, body: str) -> np.ndarray | None:
    """Distance of every node to its target at every time, shape (n_t, n_k); None if the body has no target."""
    scene = solution.system.scene
    shape = scene.model(flexible_body(scene, body).model, "shape").shape
    if shape is None:
        return None
    q = np.real(solution.q[:, elastic_coordinates(solution, body)])
    position = shape.position[:, :, 0] + np.einsum("kif,tf->tki", shape.position[:, :, 1:], q)
    return np.linalg.norm(position - shape.target, axis=2)


Panels = list[tuple[str, dict[str, np.ndarray]]]
"""Of each panel its label with the unit, and name -> values over time."""


def draw_curves(solution: Solution, path: Path, width: int) -> None:
    """Write the curves as one picture with a panel per quantity."""
    draw_panels(solution, _stress_panels(solution) + _shape_panels(solution) + _rotation_panels(solution), path, width)


def draw_panels(solution: Solution, panels: Panels, path: Path, width: int) -> None:
    """Write panels of curves over the times of a solution below each other."""
    with drawing_settings({}):
        _draw_panels(solution, panels, path, width)


def _draw_panels(solution: Solution, panels: Panels, path: Path, width: int) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 0.8 + 2.6 * len(panels)), dpi=width / 10, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axis, (label, curves) in zip(axes, panels, strict=True):
        for (name, values), style in zip(curves.items(), ("-", "--", "-.", ":") * len(curves), strict=False):
            axis.plot(solution.times, values, style, marker=".", label=name)
        axis.set_ylabel(label)
        axis.set_ylim(bottom=0 if min(np.min(values) for values in curves.values()) >= 0 else None)
        axis.grid(alpha=0.3)
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    axes[-1].set_xlabel(f"time in {unit(solution.system.scene.units, 'time')}")
    axes[-1].set_xlim(solution.times[0], solution.times[-1])
    figure.savefig(path, format="png")


def _flexible(solution: Solution) -> list[str]:
    return [name for name, body in solution.system.scene.bodies.items() if isinstance(body, Flexible)]


def _stress_panels(solution: Solution) -> Panels:
    curves: dict[str, Any] = {}
    for body in _flexible(solution):
        low, high = stress_range(solution, body).T
        curves |= {f"{body}, largest": high, f"{body}, smallest": low}
    return [(f"stress in {unit(solution.system.scene.units, 'stress')}", curves)] if curves else []


def _shape_panels(solution: Solution) -> Panels:
    curves: dict[str, Any] = {}
    for body in _flexible(solution):
        errors = shape_errors(solution, body)
        if errors is not None:
            curves |= {f"{body}, largest": errors.max(axis=1), f"{body}, RMS": np.sqrt((errors**2).mean(axis=1))}
    return [(f"distance to target in {unit(solution.system.scene.units, 'length')}", curves)] if curves else []


def _rotation_panels(solution: Solution) -> Panels:
    scene = solution.system.scene
    framed = [name for name, body in scene.bodies.items() if body.has_frame]
    curves = {name: np.real(solution.q[:, solution.coordinates(name).start + 2]) for name in framed}
    return [(f"rotation in {unit(scene.units, 'angle')}", merged(curves))] if curves else []


def merged(curves: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The same curves, each drawn once: those that coincide, to a millionth of the largest value, share a name."""
    near = 1e-6 * max(np.abs(values).max() for values in curves.values())
    groups: list[list[str]] = []
    for name, values in curves.items():
        same = [group for group in groups if np.allclose(curves[group[0]], values, rtol=0, atol=near)]
        if same:
            same[0].append(name)
        else:
            groups.append([name])
    return {", ".join(group): curves[group[0]] for group in groups}
