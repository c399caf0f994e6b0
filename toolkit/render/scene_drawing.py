"""A scene at one instant in one panel: outlines, mechanism, skins with their stress, supports, joints and their names."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.render import parts
from toolkit.render.configuration import Configuration, joints_by_place
from toolkit.render.labels import write_names
from toolkit.render.look import Look
from toolkit.render.panel import FRAME, Panel
from toolkit.render.skin_shape import drawn_model, skin_shape

UNDEFORMED, TARGET, ROD, SUPPORT = "#909090", "#1a8f3c", "#8fa3bf", "#7a4a1e"
COLORS = "coolwarm"
_OUTLINE, _RODS, _SKIN, _TARGET, _SUPPORT, _JOINTS = -2.0, 0.0, 1.0, 1.5, 2.0, 2.5
"""Heights above the plane in diameters of a tube: what covers what."""


def draw_scene(panel: Panel, configuration: Configuration, look: Look, names: bool) -> Any:
    """Everything at one instant in one panel; returns the last skin's actor, which the colour bar belongs to, or None."""
    radius = look.extent / 180
    lines = _draw_outlines(panel, configuration, look, 2 * radius)
    lines += _draw_mechanism(panel, configuration, radius)
    actor = _draw_skins(panel, configuration, look, _SKIN * 2 * radius)
    for point in [*configuration.ground_points(), *_clamps(configuration, look)]:
        panel.draw(parts.ground_mark(point, 3 * radius, _SUPPORT * 2 * radius), color=SUPPORT, line_width=2)
        lines.append(point + np.array([[0.0, 0.0], [-3.0, -3.0], [0.0, -3.0], [3.0, -3.0]]) * radius)
    joints = joints_by_place(configuration, radius / 2)
    for point, _ in joints:
        panel.draw(parts.dot(point, 1.5 * radius, _JOINTS * 2 * radius), color="black", lighting=False)
        panel.draw(parts.dot(point, 0.8 * radius, (_JOINTS + 0.5) * 2 * radius), color="white", lighting=False)
    if names:
        write_names(panel, joints, lines)
    return actor


def _draw_outlines(panel: Panel, configuration: Configuration, look: Look, layer: float) -> list[np.ndarray]:
    """The undeformed outline, below all, and the target, above the skin; returns what labels should not cover."""
    drawn = []
    for body in look.thickness:
        mesh = drawn_model(configuration, body).mesh
        if mesh is None:
            continue
        outline, target = (configuration.place(body, points) for points in (mesh.outline, mesh.target_outline))
        if len(outline) > 1:
            panel.draw(parts.line(outline, _OUTLINE * layer), color=UNDEFORMED, line_width=2, lighting=False)
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
    links = configuration.links()
    for ends in links:
        panel.draw(parts.line(ends, _RODS), color=ROD, line_width=3)
    return rods + links


def _draw_skins(panel: Panel, configuration: Configuration, look: Look, height: float) -> Any:
    actor = None
    for body, true in look.thickness.items():
        shape, thickness = skin_shape(configuration, body), max(true, 0.6 * panel.letter / panel.scale)
        if shape is None:
            continue
        name = f"stress of {body}"
        band = parts.skin(shape, thickness, name, height)
        actor = panel.draw(band, scalars=name, cmap=COLORS, clim=_limits(look), lighting=False)
        for fibre in range(2):
            edge = shape.fibres(thickness)[:, :, fibre].reshape(-1, 2)
            panel.draw(parts.line(edge, height * 1.01), color=FRAME, line_width=1, lighting=False)
    return actor


def _clamps(configuration: Configuration, look: Look) -> list[np.ndarray]:
    """Nodes of grounded bodies that no elastic coordinate moves."""
    found = []
    for body in look.thickness:
        mesh = drawn_model(configuration, body).mesh
        if mesh is not None and not configuration.scene.body(body).has_frame:
            still = ~np.any(mesh.recovery[:, 1:].reshape(len(mesh.nodes), -1), axis=1)
            found += list(configuration.place(body, mesh.nodes[still]))
    return found


def _limits(look: Look) -> tuple[float, float]:
    limit = look.stress_limit or 1.0
    return -limit, limit
