"""The scene at one instant in axes of matplotlib: skins coloured by a field, rods, joints, outlines; x and y to one scale."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize

from toolkit.foundation.units import unit
from toolkit.render.moment import names_by_place
from toolkit.render.plane.configuration import Configuration
from toolkit.render.plane.skin_shape import drawn_model, skin_shape
from toolkit.report.sheet import COLORS, SIGNED, WIDTH

MARGIN = 0.14
"""Round what is shown, relative to half of its extent: room for names of joints and for the thickness of bands."""
_CLEAR = {"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.7}
UNDEFORMED, TARGET, ROD, INK = "#8a8a8a", COLORS[1], "#7890b0", "#202020"


def window(moments: Sequence[Configuration], skins: Sequence[str]) -> np.ndarray:
    """Corners (2, 2) of what bodies and joints need at some instants, with a margin; long contours beyond them are cut off."""
    shapes = [shape.line.reshape(-1, 2) for each in moments for body in skins if (shape := skin_shape(each, body))]
    rods = [ends for each in moments for body in each.scene.bodies for ends in each.segments(body)]
    others = [points for each in moments for points in each.named_points().values()]
    points = np.vstack([*shapes, *rods, *others, np.zeros((0, 2))])
    points = points if len(points) else np.array([[-1.0, -1.0], [1.0, 1.0]])
    low, high = points.min(axis=0), points.max(axis=0)
    half, middle = (high - low) / 2, (high + low) / 2
    half = np.maximum(half, 0.2 * max(half.max(), 1e-9)) + MARGIN * max(half.max(), 1e-9)
    return np.array([middle - half, middle + half])


def panel_height(corners: np.ndarray) -> float:
    """Height in inches at which a panel as wide as the sheet has one scale for x and y."""
    wide, high = corners[1] - corners[0]
    return float(min((WIDTH - 0.9) * high / wide, 1.3 * WIDTH))


def equal_axes(axes: Axes, moment: Configuration, corners: np.ndarray, bottom: bool = True) -> None:
    """One scale for x and y in a window, with labels."""
    length = unit(moment.scene.units, "length")
    axes.set_xlim(*corners[:, 0])
    axes.set_ylim(*corners[:, 1])
    axes.set_aspect("equal", adjustable="box")
    axes.set_ylabel(f"y in {length}")
    if bottom:
        axes.set_xlabel(f"x in {length}")


def draw_band(axes: Axes, moment: Configuration, body: str, fibres: np.ndarray, colors: Normalize, thickness: float) -> Any:
    """A skin as two bands, outer and inner fibre, coloured by values (n_e, POINTS, 2); returns what a colour bar belongs to."""
    shape = skin_shape(moment, body)
    if shape is None:
        return None
    edges = shape.fibres(thickness)  # (n_e, POINTS, fibre, 2)
    middle = np.broadcast_to(shape.line[:, :, None], edges.shape)
    corners = np.stack([edges[:, :-1], edges[:, 1:], middle[:, 1:], middle[:, :-1]], axis=3)  # (n_e, POINTS - 1, fibre, 4, 2)
    values = (fibres[:, :-1] + fibres[:, 1:]) / 2
    band = PolyCollection(
        list(corners.reshape(-1, 4, 2)), array=values.ravel(), cmap=SIGNED, norm=colors, edgecolors="face", linewidths=0.2
    )
    axes.add_collection(band)
    axes.add_collection(LineCollection(list(np.moveaxis(edges, 2, 0).reshape(-1, edges.shape[1], 2)), colors=INK, linewidths=0.4))
    return band


def draw_outlines(axes: Axes, moment: Configuration, body: str) -> None:
    """The undeformed and the target contour in the place of the body."""
    mesh = drawn_model(moment, body).mesh
    if mesh is None:
        return
    for outline, color, dashes, label in (
        (mesh.outline, UNDEFORMED, "-", "undeformed"),
        (mesh.target_outline, TARGET, "--", "target"),
    ):
        if len(outline) > 1:
            x, y = moment.place(body, outline).T
            axes.plot(x, y, dashes, color=color, linewidth=1.4, label=label, zorder=2.5 if dashes == "--" else 1)


def draw_line(axes: Axes, moment: Configuration, body: str, **style: Any) -> None:
    """The middle line of a skin."""
    shape = skin_shape(moment, body)
    if shape is not None:
        x, y = shape.line.reshape(-1, 2).T
        axes.plot(x, y, **style)


def draw_mechanism(axes: Axes, moment: Configuration, color: str = ROD, names: bool = True, width: float = 4.0) -> None:
    """Rigid bodies as thick lines, springs and distance joints as thin ones, points as circles with their names."""
    rods = [ends for body in moment.scene.bodies for ends in moment.segments(body)]
    axes.add_collection(LineCollection(rods, colors=color, linewidths=width, capstyle="round", zorder=1.5))
    axes.add_collection(LineCollection([moment.ends(each) for each in moment.links()], colors=color, linewidths=1.0, zorder=1.5))
    if not names:
        return
    for point, name in names_by_place(moment, 1e-3 * moment.scene.size):
        axes.plot(*point, "o", color="white", markeredgecolor=INK, markersize=5, zorder=3)
        axes.annotate(
            name.replace("_", " "), (point[0], point[1]), (5, 4), textcoords="offset points", fontsize=9, zorder=4, bbox=_CLEAR
        )
