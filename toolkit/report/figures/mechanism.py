"""The mechanism in its first, some middle and its last position, with outlines and target (paper, fig. 5b)."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D

from toolkit.render.plane.names import write_names
from toolkit.render.plane.parts import draw_line, draw_mechanism, draw_outlines, draw_sections, draw_symbols
from toolkit.render.plane.scene_picture import contour_keys
from toolkit.render.plane.window import open_windows, panel_height, window
from toolkit.render.sheet import NARROW, sheet
from toolkit.report.drawing import Drawing
from toolkit.report.material import Material


def mechanism(material: Material) -> list[Drawing]:
    """All bodies in one panel."""
    *ghosts, last = [material.moment(step) for step in material.telling]
    shades = [to_hex(shade) for shade in colormaps["Greys"](np.linspace(0.3, 0.55, max(len(ghosts), 1)))]
    corners = window(material.look.points)
    with sheet(panel_height(corners, NARROW) + 1.0) as (figure, axes):
        panel = axes[0, 0]
        if material.skins:
            end = Line2D([], [], color="black", linewidth=3.0, label="end")
            figure.legend(handles=[*contour_keys(material.look, last), end], loc="outside upper center", ncols=3)
        open_windows(figure, last, {panel: corners})
        for body in material.skins:
            draw_outlines(panel, last, body, material.look)
        for moment, shade in zip(ghosts, shades, strict=False):
            draw_sections(panel, moment, material.look.solids, edge=shade)
            draw_mechanism(panel, moment, color=shade, edge=shade, width=2.5, but=material.look.solids)
            for body in material.skins:
                draw_line(panel, moment, body, color=shade, linewidth=1.5)
        draw_sections(panel, last, material.look.solids, filled=True)
        draw_mechanism(panel, last, but=material.look.solids)
        for body in material.skins:
            draw_line(panel, last, body, color="black", linewidth=3.0)
        draw_symbols(panel, last)
        write_names(panel, last, bodies=True)
    caption = "The last position in full, earlier ones in grey; circles are joints."
    return [Drawing("mechanism", "Motion of the mechanism", caption, figure)]
