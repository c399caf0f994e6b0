"""The motion as an animated GIF."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

from toolkit.foundation.files.replaced_file import write_whole
from toolkit.foundation.units import unit
from toolkit.render.gif import MOST_FRAMES, gif
from toolkit.render.plane.skin_shape import skin_shape
from toolkit.report.figures.stress_motion import BAND
from toolkit.report.material import Material
from toolkit.report.shape_panel import draw_band, draw_mechanism, draw_outlines, equal_axes, panel_height, window
from toolkit.report.sheet import sheet, symmetric

RESOLUTION = 130
"""Pixels per inch."""


def frame_steps(material: Material) -> np.ndarray:
    """Steps that are shown, evenly spread, both ends among them."""
    count = min(material.solution.steps + 1, MOST_FRAMES)
    return np.unique(np.linspace(0, material.solution.steps, count).round().astype(int))


def animate(material: Material, path: Path, progress: Callable[[int, int], None] = lambda *_: None) -> Path:
    """Write the motion with the stress of the skins; the file is looped by whatever shows it."""
    steps = frame_steps(material)
    moments = [material.moment(step) for step in steps]
    corners = window([moments[0], moments[len(moments) // 2], moments[-1]], material.skins)
    colors = symmetric([body.stress for body in material.results.bodies.values()])
    frames = []
    for number, moment in enumerate(moments):
        frames.append(_frame(material, moment, corners, colors))
        progress(number + 1, len(moments))
    write_whole(path, gif(frames))
    return path


def _frame(material: Material, moment, corners: np.ndarray, colors) -> Image.Image:
    band = None
    with sheet(panel_height(corners) + (1.4 if material.skins else 0.8)) as (figure, axes):
        panel = axes[0, 0]
        for body in material.skins:
            draw_outlines(panel, moment, body)
        draw_mechanism(panel, moment)
        for body in material.skins:
            shape = skin_shape(moment, body)
            if shape:
                band = draw_band(panel, moment, body, shape.stress, colors, BAND * material.scene.size)
        equal_axes(panel, moment, corners)
        panel.set_title(f"t = {moment.time:.3f} {unit(material.scene.units, 'time')}", loc="left")
        if band is not None:
            figure.colorbar(
                band, ax=panel, label=f"stress in {unit(material.scene.units, 'stress')}", location="bottom", aspect=40
            )
        figure.set_dpi(RESOLUTION)
        figure.draw_without_rendering()  # the layout needs one round to know how large titles are
        figure.canvas.draw()
        return Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")  # type: ignore[attr-defined]
