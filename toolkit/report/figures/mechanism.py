"""The mechanism in its first, some middle and its last position, with outlines and target (paper, fig. 5b)."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps

from toolkit.report.material import Material
from toolkit.report.shape_panel import ROD, draw_line, draw_mechanism, draw_outlines, equal_axes, panel_height, window
from toolkit.report.sheet import Drawing, sheet

GHOSTS = 3


def mechanism(material: Material) -> list[Drawing]:
    """All bodies in one panel."""
    first, last = material.moment(0), material.moment(-1)
    ghosts = np.unique(np.linspace(0, material.solution.steps, GHOSTS + 2).round().astype(int))[:-1]
    shades = colormaps["Greys"](np.linspace(0.3, 0.55, max(len(ghosts), 1)))
    corners = window([first, last, *(material.moment(step) for step in ghosts)], material.skins)
    with sheet(panel_height(corners) + 1.1) as (figure, axes):
        panel = axes[0, 0]
        for body in material.skins:
            draw_outlines(panel, first, body)
        for step, shade in zip(ghosts, shades, strict=False):
            draw_mechanism(panel, material.moment(step), color=shade, names=False, width=2.5)
            for body in material.skins:
                draw_line(panel, material.moment(step), body, color=shade, linewidth=1.5)
        draw_mechanism(panel, last, color=ROD)
        for body in material.skins:
            draw_line(panel, last, body, color="black", linewidth=3.0, label=f"{body}, end" if len(material.skins) > 1 else "end")
        equal_axes(panel, last, corners)
        if material.skins:
            figure.legend(loc="outside upper center", ncols=4)
    caption = "The last position in full, earlier ones in grey; circles are joints. Compare figure 5b of the paper."
    return [Drawing("mechanism", "Motion of the mechanism", caption, figure)]
