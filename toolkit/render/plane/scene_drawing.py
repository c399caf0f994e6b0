"""A scene at one instant in one panel: skins with their stress, outlines, mechanism, joints and supports, names."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.render import parts
from toolkit.render.moment import names_by_place
from toolkit.render.panel import FRAME, Panel
from toolkit.render.plane.configuration import Configuration
from toolkit.render.plane.labels import write_names
from toolkit.render.plane.look import Look
from toolkit.render.plane.skin_mesh import skin_mesh
from toolkit.render.plane.skin_shape import drawn_model, skin_shape
from toolkit.render.plane.symbols import clamps, symbols

UNDEFORMED, TARGET, ROD, SUPPORT = "#707070", "#1a8f3c", "#8fa3bf", "#7a4a1e"
COLORS = "coolwarm"
_RODS, _SKIN, _OUTLINE, _TARGET, _SYMBOLS, _PINS = 0.0, 1.0, 1.3, 1.5, 2.0, 2.5
"""Heights above the plane in diameters of a tube: what covers what."""


def draw_scene(panel: Panel, configuration: Configuration, look: Look) -> Any:
    """Everything at one instant in one panel; returns the last skin's actor, which the colour bar belongs to, or None."""
    radius = look.extent / 180
    actor, skins = _draw_skins(panel, configuration, look, _SKIN * 2 * radius)
    lines = _draw_outlines(panel, configuration, look, 2 * radius)
    lines += skins + _draw_mechanism(panel, configuration, radius) + _draw_symbols(panel, configuration, radius)
    write_names(panel, _labels(configuration, radius / 2), lines)
    return actor


def drawn_thickness(panel: Panel, true: float) -> float:
    """The thickness of a skin, or more if its two colours could not be told apart."""
    return max(true, 0.5 * panel.letter / panel.scale)


def _draw_outlines(panel: Panel, configuration: Configuration, look: Look, layer: float) -> list[np.ndarray]:
    """The undeformed outline and the target, above the skin; returns what labels should not cover."""
    drawn = []
    for body in look.thickness:
        mesh = drawn_model(configuration, body).mesh
        if mesh is None:
            continue
        outline, target = (configuration.place(body, points) for points in (mesh.outline, mesh.target_outline))
        if len(outline) > 1:
            panel.draw(parts.line(outline, _OUTLINE * layer), color=UNDEFORMED, line_width=1.5, lighting=False)
        if len(target) > 1:
            broken = parts.dashes(target, 0.5 * panel.letter / panel.scale, _TARGET * layer)
            panel.draw(broken, color=TARGET, line_width=3, lighting=False)
        drawn += [outline, target]
    return drawn


def _draw_mechanism(panel: Panel, configuration: Configuration, radius: float) -> list[np.ndarray]:
    """Rigid bodies as tubes, springs and distance joints as lines; returns them."""
    rods = [ends for body in configuration.scene.bodies for ends in configuration.segments(body)]
    for ends in rods:
        panel.draw(parts.tube(ends, radius), color=ROD, smooth_shading=True)
    links = [configuration.ends(each) for each in configuration.links()]
    for ends in links:
        panel.draw(parts.line(ends, _RODS), color=ROD, line_width=3)
    return rods + links


def _draw_skins(panel: Panel, configuration: Configuration, look: Look, height: float) -> tuple[Any, list[np.ndarray]]:
    """The skins with their stress; returns the last one's actor and their edges."""
    actor, edges = None, []
    for body, true in look.thickness.items():
        shape, thickness = skin_shape(configuration, body), drawn_thickness(panel, true)
        if shape is None:
            continue
        name = f"stress of {body}"
        band = skin_mesh(shape, thickness, name, height)
        actor = panel.draw(band, scalars=name, cmap=COLORS, clim=_limits(look), lighting=False)
        edges += [shape.fibres(thickness)[:, :, fibre].reshape(-1, 2) for fibre in range(2)]
    for edge in edges:
        panel.draw(parts.line(edge, height * 1.01), color=FRAME, line_width=1, lighting=False)
    return actor, edges


def _draw_symbols(panel: Panel, configuration: Configuration, radius: float) -> list[np.ndarray]:
    """Pins as dots, everything else as lines; returns the lines, of a dot its edge."""
    drawn = []
    for symbol in symbols(configuration):
        lines = symbol.lines(3 * radius)
        if symbol.kind == "pin":
            panel.draw(parts.dot(symbol.point, 1.5 * radius, _PINS * 2 * radius), color="black", lighting=False)
            panel.draw(parts.dot(symbol.point, 0.8 * radius, (_PINS + 0.5) * 2 * radius), color="white", lighting=False)
        else:
            panel.draw(parts.lines(lines, _SYMBOLS * 2 * radius), color=SUPPORT, line_width=2, lighting=False)
        drawn += lines
    return drawn


def _labels(configuration: Configuration, tolerance: float) -> list[tuple[np.ndarray, str]]:
    """Names of points, and which body is clamped where no named point is."""
    named = names_by_place(configuration, tolerance)
    for body, points in clamps(configuration).items():
        if not any(np.hypot(*(points[0] - place)) < tolerance for place, _ in named):
            named.append((points[0], f"{body} clamped"))
    return named


def _limits(look: Look) -> tuple[float, float]:
    limit = look.stress_limit or 1.0
    return -limit, limit
