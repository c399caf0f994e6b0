"""Stress in skins and meshed bodies during the motion (paper, fig. 7)."""

from __future__ import annotations

from toolkit.foundation.units import unit
from toolkit.render.plane.scene_picture import overview_figure
from toolkit.render.sheet import NARROW
from toolkit.report.drawing import Drawing
from toolkit.report.material import Material


def stress_motion(material: Material) -> list[Drawing]:
    """Skins at some instants, coloured by the stress of their outer and inner fibre, and meshed bodies by theirs."""
    if not material.look.stress_limit:
        return []
    moments = [material.moment(step) for step in material.telling]
    bands = "Outer half of the band: outer fibre; inner half: inner fibre. " if material.skins else ""
    caption = f"{bands}Red is tension, blue compression."
    figure = overview_figure(moments, material.look, NARROW, columns=1)
    return [Drawing("stress_motion", "Stress during the motion", caption, figure)]


def stress(material: Material) -> str:
    """Label of the unit of stress."""
    return unit(material.scene.units, "stress")
