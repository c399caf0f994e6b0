"""Pictures of a scene in the plane: one instant with its detail, or several instants beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from toolkit.render import parts
from toolkit.render.canvas import canvas
from toolkit.render.configuration import Configuration
from toolkit.render.curves import shape_errors, stress_range
from toolkit.render.look import Look
from toolkit.render.panel import FRAME, INK, Panel, Window, letter
from toolkit.render.scene_drawing import TARGET, UNDEFORMED, draw_scene
from toolkit.units import unit

Place = tuple[int, int, int, int]
"""Left, bottom, width, height in pixels."""
_MARGIN = 0.07
"""Round what is drawn, relative to its extent."""
_LEFT = ("left", "center")


def draw_instant(moment: Configuration, look: Look, path: Path, width: int) -> None:
    """One instant: the scene, and beside it the detail where it moves most."""
    letters, height = width // 70, width // 2
    foot = 8 * letters if look.stress_limit else 5 * letters
    tall = height - foot - 3 * letters
    split = round(0.64 * width) if look.detail is not None else width
    contents = [((4 * letters, foot, split - 5 * letters, tall), look.points, _MARGIN)]
    if look.detail is not None:
        contents.append(((split + 4 * letters, foot, width - split - 5 * letters, tall), look.detail, 0.0))
    titles = [caption(moment, look), "detail (frame on the left)"]
    with canvas(path, width, height, len(contents)) as plotter:
        panels = [
            Panel(plotter, number, place, Window.around(points, place[2] / place[3], margin), letters)
            for number, (place, points, margin) in enumerate(contents, start=1)
        ]
        for panel, title in zip(panels, titles, strict=False):
            actor = _draw_panel(panel, title, moment, look, names=True)
            panel.ticks(0, f"x, y in {unit(moment.scene.units, 'length')}")
        if len(panels) > 1:
            panels[0].draw(parts.line(panels[1].window.outline), color=FRAME)
        _legend(plotter, look, moment, actor, letters)


def draw_overview(moments: Sequence[Configuration], look: Look, path: Path, width: int) -> None:
    """Several instants in one picture, two beside each other."""
    letters, columns = width // 75, min(2, len(moments))
    rows = -(-len(moments) // columns)
    wide = (width - letters) // columns - letters
    tall, head, foot = round(0.55 * wide), 5 * letters // 2, 11 * letters // 2 if look.thickness else letters
    with canvas(path, width, foot + rows * (tall + head), len(moments)) as plotter:
        for k, moment in enumerate(moments):
            row, column = divmod(k, columns)
            place: Place = (letters + column * (wide + letters), foot + (rows - 1 - row) * (tall + head), wide, tall)
            panel = Panel(plotter, k + 1, place, Window.around(look.points, wide / tall, _MARGIN), letters)
            actor = _draw_panel(panel, caption(moment, look), moment, look, names=False)
        _legend(plotter, look, moments[0], actor, letters)


def caption(moment: Configuration, look: Look) -> str:
    """Time, range of the stress and, if one body has a target, the distance to it."""
    solution, step, units = moment.solution, moment.step, moment.scene.units
    words = [f"t = {moment.time:.4g} {unit(units, 'time')}"]
    if look.stress_limit:
        ranges = np.array([stress_range(solution, body)[step] for body in look.thickness])
        words.append(f"stress {ranges.min():.3g} to {ranges.max():.3g} {unit(units, 'stress')}")
    errors = [each[step] for body in look.thickness if (each := shape_errors(solution, body)) is not None]
    if len(errors) == 1:
        words.append(f"RMS distance to target {np.sqrt((errors[0] ** 2).mean()):#.3g} {unit(units, 'length')}")
    return ",  ".join(words)


def _draw_panel(panel: Panel, title: str, moment: Configuration, look: Look, names: bool) -> Any:
    """Open the panel, draw the scene and write a title above; returns the actor with the stress, or None."""
    panel.open()
    actor = draw_scene(panel, moment, look, names)
    panel.plotter.subplot(0, 0)
    above = np.array([panel.place[0], panel.place[1] + panel.place[3] + 1.2 * panel.letter])
    letter(panel.plotter, title, above, panel.letter, INK, _LEFT)
    return actor


def _legend(plotter: Any, look: Look, moment: Configuration, actor: Any, letters: int) -> None:
    """Colour bar at the lower left, meaning of the lines at the lower right."""
    if actor is None:
        return
    plotter.subplot(0, 0)
    width, height = plotter.window_size
    if look.stress_limit:
        bar = plotter.add_scalar_bar(
            " ", mapper=actor.mapper, vertical=False, n_labels=5, fmt="%.6g", position_x=0.06, position_y=0.7 * letters / height,
            width=0.5, height=3 * letters / height, label_font_size=letters, color=INK, render=False,
        )  # fmt: skip
        bar.SetUnconstrainedFontSize(True)
        letter(plotter, f"stress in {unit(moment.scene.units, 'stress')}", np.array([0.31 * width, 3.9 * letters]), letters)
    entries = (("— undeformed", UNDEFORMED), ("– – target", TARGET), ("deformed, stress of outer and inner fibre", INK))
    for k, (text, color) in enumerate(entries):
        letter(plotter, text, np.array([0.64 * width, (3.9 - 1.4 * k) * letters]), letters, color, _LEFT)
