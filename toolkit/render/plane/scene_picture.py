"""Pictures of a scene in the plane: one instant with its detail, or several instants beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from toolkit.foundation.units import unit
from toolkit.render import parts
from toolkit.render.canvas import canvas
from toolkit.render.layout import COLUMNS, color_bar, explain, head_line, overview_places
from toolkit.render.panel import FRAME, INK, Panel, Place, Window
from toolkit.render.plane.configuration import Configuration
from toolkit.render.plane.curves import shape_errors, stress_range
from toolkit.render.plane.look import Look
from toolkit.render.plane.scene_drawing import TARGET, UNDEFORMED, draw_scene, drawn_thickness
from toolkit.render.plane.skin_shape import drawn_model

_MARGIN = 0.07
"""Round what is drawn, relative to its extent."""


def draw_instant(moment: Configuration, look: Look, path: Path, width: int) -> None:
    """One instant: the scene, and beside it the detail where it moves most."""
    letters, height = width // 70, width // 2
    foot = 9 * letters if look.thickness else 5 * letters
    tall = height - foot - 3 * letters
    split = round(0.64 * width) if look.detail is not None else width
    place: Place = (4 * letters, foot, split - 5 * letters, tall)
    beside: Place = (split + 4 * letters, foot, width - split - 5 * letters, tall)
    windows = instant_windows(look, place[2] / tall, beside[2] / tall)
    titles = [",  ".join(caption(moment, look)), "detail (frame on the left)"]
    with canvas(path, width, height, len(windows)) as plotter:
        panels = [Panel(plotter, k + 1, (place, beside)[k], letters, window) for k, window in enumerate(windows)]
        for panel, title in zip(panels, titles, strict=False):
            actor = _draw_panel(panel, title, moment, look)
            panel.ticks(0, f"x, y in {unit(moment.scene.units, 'length')}")
        if len(panels) > 1:
            panels[0].draw(parts.line(panels[1].window.outline), color=FRAME)
        _legend(panels, look, moment, actor)


def instant_windows(look: Look, aspect: float, detail_aspect: float) -> list[Window]:
    """The main window, and that of the detail if there is one; the main window holds the frame of the detail."""
    main = Window.around(look.points, aspect, _MARGIN)
    if look.detail is None:
        return [main]
    detail = Window.around(look.detail, detail_aspect, 0.0)
    return [Window.around(np.vstack([main.outline, detail.outline]), aspect, 0.01), detail]


def draw_overview(moments: Sequence[Configuration], look: Look, path: Path, width: int) -> None:
    """Several instants in one picture, two beside each other; numbers of ticks along its left and lower edge."""
    letters = width // 60
    places, height = overview_places(len(moments), width, 9 * letters if look.thickness else 4 * letters)
    window = Window.around(look.points, places[0][2] / places[0][3], _MARGIN)
    with canvas(path, width, height, len(moments)) as plotter:
        panels = [Panel(plotter, k + 1, place, letters, window) for k, place in enumerate(places)]
        for panel, moment in zip(panels, moments, strict=True):
            words = caption(moment, look)
            title = "\n".join(",  ".join(line) for line in (words[:2], words[2:]) if line)
            actor = _draw_panel(panel, title, moment, look)
            outer = [panel.number + COLUMNS > len(moments), panel.place[0] == places[0][0]]
            panel.ticks(0, f"x, y in {unit(moment.scene.units, 'length')}", np.flatnonzero(outer).tolist())
        _legend(panels, look, moments[0], actor)


def caption(moment: Configuration, look: Look) -> list[str]:
    """Time, range of the stress and, if one body has a target, the distance to it; digits as fine as the scene needs."""
    solution, step, units = moment.solution, moment.step, moment.scene.units
    words = [f"t = {moment.time:.4g} {unit(units, 'time')}"]
    if look.stress_limit:
        ranges = np.array([stress_range(solution, body)[step] for body in look.thickness])
        low, high = (even(value, look.stress_limit / 100) for value in (ranges.min(), ranges.max()))
        words.append(f"stress {low} to {high} {unit(units, 'stress')}")
    errors = [each[step] for body in look.thickness if (each := shape_errors(solution, body)) is not None]
    if len(errors) == 1:
        rms = even(np.sqrt((errors[0] ** 2).mean()), look.extent * 1e-5)
        words.append(f"RMS distance to target {rms} {unit(units, 'length')}")
    return words


def even(value: float, finest: float) -> str:
    """A number with as many decimals as it takes to show `finest`, however large it is itself; in powers of ten if those are many."""
    decimals = max(0, -int(np.floor(np.log10(finest))))
    return f"{round(value, decimals) + 0.0:.{decimals}f}" if decimals < 6 and finest < 1e3 else f"{value:.2e}"


def _draw_panel(panel: Panel, title: str, moment: Configuration, look: Look) -> Any:
    """Open the panel, draw the scene and write a title above; returns the actor with the stress, or None."""
    panel.open()
    actor = draw_scene(panel, moment, look)
    head_line(panel, title)
    return actor


def _legend(panels: Sequence[Panel], look: Look, moment: Configuration, actor: Any) -> None:
    """Colour bar at the lower left, meaning of the lines at the lower right."""
    if actor is None:
        return
    plotter, letters = panels[0].plotter, panels[0].letter
    if look.stress_limit:
        color_bar(plotter, actor, f"stress in {unit(moment.scene.units, 'stress')}", letters)
    explain(plotter, meanings(panels, look, moment), letters)


def meanings(panels: Sequence[Panel], look: Look, moment: Configuration) -> list[tuple[str, str]]:
    """What lines and bands are, with their colours; only what is drawn, and a word where skins are thicker than they are."""
    meshes = [drawn_model(moment, body).mesh for body in look.thickness]
    entries = [("— undeformed", UNDEFORMED, "outline"), ("– – target", TARGET, "target_outline")]
    found = [(text, color) for text, color, part in entries if any(len(getattr(mesh, part)) > 1 for mesh in meshes)]
    stress = ", stress of outer and inner fibre" if look.stress_limit else ""
    found.append((f"deformed{stress}", INK))
    thick = [any(drawn_thickness(panel, true) > true for true in look.thickness.values()) for panel in panels]
    if any(thick):
        found.append(("thickness not to scale" if all(thick) else "thickness to scale in the detail only", INK))
    return found
