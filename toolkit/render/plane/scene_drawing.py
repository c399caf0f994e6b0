"""A planar scene at one instant in axes: the one place that draws it, for pictures and for the report."""

from __future__ import annotations

from matplotlib.axes import Axes

from toolkit.render.plane.configuration import Configuration
from toolkit.render.plane.look import Look
from toolkit.render.plane.parts import draw_band, draw_mechanism, draw_outlines, draw_solid, draw_symbols
from toolkit.render.plane.skin_shape import skin_shape
from toolkit.render.plane.solid_shape import solid_shape


def draw_scene(axes: Axes, moment: Configuration, look: Look) -> None:
    """Skins with their stress, outlines, mechanism, joints and supports in a window that is open; names come when the figure is settled."""
    draw_mechanism(axes, moment, but=look.solids)
    for body in look.solids:
        solid = solid_shape(moment, body)
        assert solid is not None
        draw_solid(axes, solid, look.colors)
    for body, thickness in look.thickness.items():
        shape = skin_shape(moment, body)
        assert shape is not None
        draw_band(axes, moment, body, shape.stress, look.colors, thickness)
        draw_outlines(axes, moment, body, look)
    draw_symbols(axes, moment)
