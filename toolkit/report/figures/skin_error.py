"""Shapes of a skin and its distance to the target along it (paper, fig. 8)."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes

from toolkit.description.point import BodyPoint
from toolkit.foundation.units import unit
from toolkit.render.colors import UNDEFORMED
from toolkit.render.plane.parts import draw_line, draw_outlines
from toolkit.render.plane.window import open_windows, panel_height, window
from toolkit.render.sheet import COLORS, NARROW, sheet
from toolkit.report.drawing import Drawing
from toolkit.report.material import Material
from toolkit.system.flexible_bodies import flexible_body


def targeted(material: Material) -> list[str]:
    """Names of the skins that have a target."""
    return [name for name in material.skins if material.results.bodies[name].shape_error.shape[1]]


def skin_error(material: Material) -> list[Drawing]:
    """One drawing per skin with a target: shapes above, error below."""
    return [_one(material, body) for body in targeted(material)]


def _one(material: Material, body: str) -> Drawing:
    fields, length = material.results.bodies[body], unit(material.scene.units, "length")
    error = fields.shape_error[-1]
    rms = (error**2).mean() ** 0.5
    last = material.moment(-1)
    corners = window(material.look.points)
    height = panel_height(corners, NARROW)
    with sheet(height + 3.4, 2, height_ratios=(height, 2.2)) as (figure, axes):
        shapes, along = axes[:, 0]
        shapes.set_title("shapes at the end", loc="left")
        along.plot(fields.arc_length, error, "o-", color=COLORS[0], markersize=3.5)
        along.axhline(rms, color=COLORS[1], linestyle="--")
        along.set_ylim(bottom=0, top=1.25 * error.max() or 1.0)
        along.set_xlabel(f"arc length in {length}")
        along.set_ylabel(f"distance in {length}")
        told = f"distance to the target, largest {error.max():.4g} {length}\nroot mean square (dashes) {rms:.4g} {length}"
        along.set_title(told, loc="left")
        mark_points(along, material, body)
        open_windows(figure, last, {shapes: corners})
        draw_outlines(shapes, last, body, material.look)
        draw_line(shapes, last, body, color="black", linewidth=3.0, label="deformed")
        shapes.legend(loc="center right")
    caption = f"Distance of the nodes of {body} to the target, at the end of the motion."
    return Drawing(f"skin_error_{body}", f"Shape of {body} and distance to the target", caption, figure)


def mark_points(axes: Axes, material: Material, body: str, names: bool = True) -> None:
    """Vertical lines at the arc lengths where joints and loads grip a skin."""
    interfaces = material.scene.model(flexible_body(material.scene, body).model).interfaces or {}
    for name, point in material.scene.points.items():
        if isinstance(point, BodyPoint) and point.body == body and point.interface in interfaces:
            place = float(interfaces[point.interface].arc_length if point.arc_length is None else point.arc_length)
            axes.axvline(place, color=UNDEFORMED, linewidth=0.8)
            if names:
                spot: Any = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points", "ha": "right", "va": "top"}
                axes.annotate(name, (place, 1.0), (-3, -3), fontsize=9, **spot)
