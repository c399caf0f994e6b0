"""Pictures of a scene in the plane: sections, skins with their stress, mechanism and joints, at one instant or at several."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyvista

from toolkit.render import parts
from toolkit.render.configuration import Configuration, joints_by_place
from toolkit.render.curves import shape_errors, stress_range
from toolkit.render.labels import label_places
from toolkit.render.look import Look
from toolkit.render.panel import FRAME, INK, Panel, Window, letter
from toolkit.render.skin_shape import drawn_model, skin_shape
from toolkit.units import unit

UNDEFORMED, TARGET, ROD, SUPPORT = "#909090", "#1a8f3c", "#5b6b80", "#7a4a1e"
COLORS = "coolwarm"
_LINES, _RODS, _SKIN, _JOINTS = -2.0, 0.0, 1.0, 2.0
"""Heights above the plane, in tube radii times two: what covers what."""


def draw_instant(configuration: Configuration, look: Look, path: Path, width: int) -> None:
    """One instant: the scene, and beside it the detail where it moves most."""
    letters, height = width // 70, round(0.56 * width)
    foot = 8 * letters if look.stress_limit else 5 * letters
    tall = height - foot - 3 * letters
    split = round(0.64 * width) if look.detail is not None else width
    places = [(4 * letters, foot, split - 5 * letters, tall)]
    if look.detail is not None:
        places.append((split + 4 * letters, foot, width - split - 5 * letters, tall))
    with _Canvas(width, height, len(places)) as plotter:
        panels = _panels(plotter, places, look, letters)
        for panel in panels:
            actor = draw_scene(panel, configuration, look, names=True)
            panel.ticks(0, f"x, y in {unit(configuration.scene.units, 'length')}")
        plotter.subplot(0, 0)
        top = np.array([places[0][0], height - 1.6 * letters])
        letter(plotter, caption(configuration, look), top, round(1.2 * letters), INK, ("left", "center"))
        if look.detail is not None:
            letter(plotter, "detail", np.array([places[1][0], top[1]]), round(1.2 * letters), INK, ("left", "center"))
        _legend(plotter, look, configuration, actor, width, letters)
        plotter.screenshot(str(path), return_img=False)


def draw_overview(moments: Sequence[Configuration], look: Look, path: Path, width: int) -> None:
    """Several instants in one picture, two beside each other."""
    letters = width // 75
    columns = min(2, len(moments))
    rows = -(-len(moments) // columns)
    wide = (width - letters) // columns - letters
    tall = round(wide * 0.62)
    foot = 5 * letters
    height = foot + rows * (tall + round(2.6 * letters))
    places = []
    for k in range(len(moments)):
        row, column = divmod(k, columns)
        places.append((letters + column * (wide + letters), foot + (rows - 1 - row) * (tall + round(2.6 * letters)), wide, tall))
    with _Canvas(width, height, len(places)) as plotter:
        for k, (moment, place) in enumerate(zip(moments, places, strict=True)):
            window = Window.around(look.points, place[2] / place[3], 0.07)
            panel = Panel(plotter, k + 1, place, window, letters)
            panel.open()
            actor = draw_scene(panel, moment, look, names=False)
            plotter.subplot(0, 0)
            at = np.array([place[0], place[1] + place[3] + 1.2 * letters])
            letter(plotter, caption(moment, look), at, letters, INK, ("left", "center"))
        _legend(plotter, look, moments[0], actor, width, letters)
        plotter.screenshot(str(path), return_img=False)


def caption(configuration: Configuration, look: Look) -> str:
    """Time, range of the stress and distance to the target at one instant."""
    solution, step, units = configuration.solution, configuration.step, configuration.scene.units
    words = [f"t = {configuration.time:.4g} {unit(units, 'time')}"]
    for body in look.thickness:
        low, high = stress_range(solution, body)[step]
        words.append(f"{body}: stress {low:.1f} to {high:.1f} {unit(units, 'stress')}".replace("-", "−"))
        errors = shape_errors(solution, body)
        if errors is not None:
            words.append(f"RMS distance to target {np.sqrt((errors[step] ** 2).mean()):.2f} {unit(units, 'length')}")
    return ",  ".join(words)


def draw_scene(panel: Panel, configuration: Configuration, look: Look, names: bool) -> Any:
    """Everything at one instant in one panel; returns the last skin's actor, which the colour bar belongs to, or None."""
    lines, radius = _draw_lines(panel, configuration, look), look.extent / 180
    for body in configuration.scene.bodies:
        for ends in configuration.segments(body):
            panel.draw(parts.tube(ends, radius), color=ROD, smooth_shading=True)
            lines.append(ends)
    for ends in configuration.links():
        panel.draw(parts.line(ends, _RODS), color=ROD, line_width=3)
        lines.append(ends)
    actor = _draw_skins(panel, configuration, look, _SKIN * radius * 2)
    for point in [*configuration.ground_points(), *_clamps(configuration, look)]:
        panel.draw(parts.ground_mark(point, 3 * radius, _JOINTS * radius * 2), color=SUPPORT, line_width=2)
        lines.append(point + np.array([[0.0, 0.0], [-3.0, -3.0], [0.0, -3.0], [3.0, -3.0]]) * radius)
    joints = joints_by_place(configuration, radius / 2)
    for point, _ in joints:
        panel.draw(parts.dot(point, 1.5 * radius, _JOINTS * radius * 2), color="black", lighting=False)
        panel.draw(parts.dot(point, 0.8 * radius, (_JOINTS + 0.5) * radius * 2), color="white", lighting=False)
    if names:
        _write_names(panel, joints, lines)
    return actor


def _draw_lines(panel: Panel, configuration: Configuration, look: Look) -> list[np.ndarray]:
    """The undeformed and the target outline of every flexible body; returns what labels should not cover."""
    drawn, height = [], _LINES * look.extent / 90
    for body in look.thickness:
        mesh = drawn_model(configuration, body).mesh
        shape = skin_shape(configuration, body)
        if mesh is None or shape is None:
            continue
        outline, target = (configuration.place(body, points) for points in (mesh.outline, mesh.target_outline))
        panel.draw(parts.line(outline, height), color=UNDEFORMED, line_width=2, lighting=False)
        broken = parts.dashes(target, 12 / panel.scale, height / 2) if len(target) > 1 else None
        if broken is not None:
            panel.draw(broken, color=TARGET, line_width=3, lighting=False)
        drawn += [outline, target, shape.line.reshape(-1, 2)]
    return drawn


def _draw_skins(panel: Panel, configuration: Configuration, look: Look, height: float) -> Any:
    actor = None
    for body, thickness in look.thickness.items():
        shape = skin_shape(configuration, body)
        if shape is None:
            continue
        name = f"stress of {body}"
        panel.plotter.subplot(0, panel.number)
        actor = panel.plotter.add_mesh(
            parts.skin(shape, thickness, name, height), scalars=name, cmap=COLORS, clim=_limits(look), lighting=False,
            reset_camera=False, show_scalar_bar=False, render=False,
        )  # fmt: skip
        for fibre in range(2):
            edge = shape.fibres(thickness)[:, :, fibre].reshape(-1, 2)
            panel.draw(parts.line(edge, height * 1.01), color=INK, line_width=1, lighting=False)
    return actor


def _write_names(panel: Panel, joints: list[tuple[np.ndarray, str]], lines: list[np.ndarray]) -> None:
    shown = [(point, name) for point, name in joints if panel.window.contains(point)]
    if not shown:
        return
    obstacles = np.vstack([_dense(points, 6 / panel.scale) for points in [*lines, *(point[None] for point, _ in joints)]])
    obstacles = obstacles[panel.window.contains(obstacles)]
    pixels = np.array([panel.pixel(point) for point, _ in shown])
    texts, size = [name for _, name in shown], np.array(panel.place[2:])
    obstacles = np.array([panel.pixel(point) for point in obstacles])
    for text, place in zip(texts, label_places(pixels, texts, obstacles, panel.letter, size), strict=True):
        panel.write(text, place)


def _dense(points: np.ndarray, spacing: float) -> np.ndarray:
    """Points along a polyline at most a spacing apart."""
    if len(points) < 2:
        return points
    counts = np.ceil(np.hypot(*np.diff(points, axis=0).T) / spacing).astype(int).clip(1)
    pairs = zip(points[:-1], points[1:], counts, strict=True)
    return np.vstack([*(np.linspace(start, end, n, endpoint=False) for start, end, n in pairs), points[-1:]])


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


def _panels(plotter: Any, places: list[tuple[int, int, int, int]], look: Look, letters: int) -> list[Panel]:
    contents = [(look.points, 0.07)] + ([(look.detail, 0.0)] if look.detail is not None else [])
    panels = []
    for number, (place, (points, margin)) in enumerate(zip(places, contents, strict=True), start=1):
        panels.append(Panel(plotter, number, place, Window.around(points, place[2] / place[3], margin), letters))
        panels[-1].open()
    return panels


def _legend(plotter: Any, look: Look, configuration: Configuration, actor: Any, width: int, letters: int) -> None:
    """Colour bar at the lower left, meaning of the lines at the lower right."""
    if actor is None:
        return
    plotter.subplot(0, 0)
    height = plotter.window_size[1]
    if look.stress_limit:
        bar = plotter.add_scalar_bar(
            f"stress in {unit(configuration.scene.units, 'stress')}", mapper=actor.mapper, vertical=False, n_labels=5, fmt="%.0f",
            position_x=0.06, position_y=0.3 * letters / height, width=0.5, height=4 * letters / height,
            title_font_size=letters, label_font_size=letters, color=INK, render=False,
        )  # fmt: skip
        bar.SetUnconstrainedFontSize(True)
    entries = [("undeformed", UNDEFORMED), ("− − target", TARGET), ("deformed: stress as colour", INK)]
    for k, (text, color) in enumerate(entries):
        at = np.array([0.64 * width, (3.6 - 1.4 * k) * letters])
        letter(plotter, text, at, letters, color, ("left", "center"))


class _Canvas:
    """A plotter whose renderer 0 is the whole white sheet and the others are panels on it; closed at the end."""

    def __init__(self, width: int, height: int, panels: int) -> None:
        self.arguments = {"off_screen": True, "window_size": (width, height), "shape": (1, panels + 1), "border": False}

    def __enter__(self) -> Any:
        self.plotter = pyvista.Plotter(**self.arguments)
        self.plotter.subplot(0, 0)
        self.plotter.set_background("white", all_renderers=False)
        self.plotter.renderers[0].viewport = (0, 0, 1, 1)
        self.plotter.enable_anti_aliasing("msaa", multi_samples=8)
        return self.plotter

    def __exit__(self, *_: object) -> None:
        self.plotter.close()


__all__ = ["FRAME", "draw_instant", "draw_overview"]
