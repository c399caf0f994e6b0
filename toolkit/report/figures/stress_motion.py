"""Stress in the skins during the motion (paper, fig. 7)."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.units import unit
from toolkit.render.plane.skin_shape import skin_shape
from toolkit.report.material import Material
from toolkit.report.shape_panel import draw_band, draw_mechanism, equal_axes, panel_height, window
from toolkit.report.sheet import Drawing, sheet, symmetric

INSTANTS = 4
BAND = 0.022
"""Thickness that skins are drawn with, relative to the scene: true ones would be hairlines."""


def stress_motion(material: Material) -> list[Drawing]:
    """Skins at some instants, coloured by the stress of their outer and inner fibre."""
    if not material.skins:
        return []
    steps = np.unique(np.linspace(0, material.solution.steps, INSTANTS + 1).round().astype(int))[-INSTANTS:]
    moments = [material.moment(step) for step in steps]
    shapes = [[skin_shape(moment, body) for body in material.skins] for moment in moments]
    colors = symmetric([shape.stress for row in shapes for shape in row if shape])
    corners = window(moments, material.skins)
    with sheet(1.3 + (panel_height(corners) + 0.3) * len(moments), len(moments), sharex=True, sharey=True) as (figure, axes):
        for panel, moment, row in zip(axes[:, 0], moments, shapes, strict=True):
            draw_mechanism(panel, moment, names=False, width=2.5)
            for body, shape in zip(material.skins, row, strict=True):
                if shape:
                    band = draw_band(panel, moment, body, shape.stress, colors, BAND * material.scene.size)
            equal_axes(panel, moment, corners, bottom=panel is axes[-1, 0])
            high = max(np.nanmax(shape.stress) for shape in row if shape)
            panel.set_title(f"t = {moment.time:.3g} {unit(material.scene.units, 'time')}, largest {high:.3g} {stress(material)}")
        figure.colorbar(band, ax=axes, label=f"stress in {stress(material)}", location="bottom", aspect=40, pad=0.02)
    caption = (
        "Outer half of the band: outer fibre; inner half: inner fibre; drawn thicker than it is. Red is tension, blue compression. "
        "Compare figure 7 of the paper."
    )
    return [Drawing("stress_motion", "Stress during the motion", caption, figure)]


def stress(material: Material) -> str:
    """Label of the unit of stress."""
    return unit(material.scene.units, "stress")
