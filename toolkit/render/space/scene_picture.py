"""Pictures of a scene in space: one instant, or several instants beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from toolkit.foundation.units import unit
from toolkit.loads.gravity import SpatialGravity
from toolkit.render.motion.names import NamesOfMotion
from toolkit.render.round_numbers import even
from toolkit.render.space.body_shape import body_shape
from toolkit.render.space.camera import Camera, natural_aspect
from toolkit.render.space.configuration import SpatialConfiguration
from toolkit.render.space.curves import stress_extremes
from toolkit.render.space.drawing import draw_spatial_scene
from toolkit.render.space.legend import draw_legend, foot
from toolkit.render.space.look import SpatialLook
from toolkit.render.space.plotter.canvas import canvas
from toolkit.render.space.plotter.layout import head_line, overview_places
from toolkit.render.space.plotter.panel import Place, SpatialPanel
from toolkit.render.stress_told import round_off, told
from toolkit.responses.stress.von_mises import point_stress

_MARGIN = 0.08
"""Round what is drawn, relative to its extent; symbols stand a little beyond it."""
_ASPECTS = 1.15, 1.8
"""Least and largest width of a panel of an overview over its height."""


def draw_spatial_instant(
    moment: SpatialConfiguration, look: SpatialLook, motion: NamesOfMotion | None, path: Path, width: int
) -> None:
    """Draw one instant, alone or of a motion."""
    letters, height = width // 70, round(0.65 * width)
    below = round(foot(moment, look) * letters)
    place: Place = (letters, below, width - 2 * letters, height - below - 3 * letters)
    _draw(path, (width, height), [place], [moment], look, letters, motion)


def draw_spatial_overview(moments: Sequence[SpatialConfiguration], look: SpatialLook, path: Path, width: int) -> None:
    """Draw several instants, two beside each other."""
    letters = width // 60
    places, height = overview_places(
        len(moments), width, round(foot(moments[0], look) * letters), natural_aspect(look.points, *_ASPECTS)
    )
    _draw(path, (width, height), places, moments, look, letters)


def _draw(
    path: Path,
    size: tuple[int, int],
    places: list[Place],
    moments: Sequence[SpatialConfiguration],
    look: SpatialLook,
    letters: int,
    motion: NamesOfMotion | None = None,
) -> None:
    camera = Camera.framing(look.points, places[0][2] / places[0][3], _MARGIN, look.view.perspective)
    actor = None
    with canvas(path, *size, len(moments)) as plotter:
        panels = [SpatialPanel(plotter, k + 1, place, letters, camera) for k, place in enumerate(places)]
        for panel in panels:
            panel.open()
        for panel, moment in zip(panels, moments, strict=True):
            actor = draw_spatial_scene(panel, moment, look, motion) or actor
            head_line(panel, ",  ".join(spatial_caption(moment, look)))
        lowest = [panel for panel in panels if panel.place[1] == places[-1][1]]
        lowest[0].scale_bar(unit(moments[0].scene.units, "length"))
        lowest[-1].compass(_gravity(moments[0]))
        draw_legend(plotter, actor, moments, look, places[0][0], letters)


def _gravity(moment: SpatialConfiguration) -> np.ndarray | None:
    found: list[Any] = [load for load in moment.scene.loads.values() if isinstance(load, SpatialGravity)]
    return np.real(np.sum([load.acceleration for load in found], axis=0)) if found else None


def spatial_caption(moment: SpatialConfiguration, look: SpatialLook) -> list[str]:
    """Caption with time and range of the stress, in digits as fine as the scene needs."""
    words = [moment.told]
    every = [(body, point_stress(body_shape(moment, body).stress)) for body in look.bodies]
    if look.bodies and not any(told(stress, round_off(moment.scene, body)) for body, stress in every):
        words.append("no stress")
    elif look.stress_limit:
        ranges = np.array([stress_extremes(moment, body) for body in look.bodies])
        low, high = ranges[:, 0].min(), np.abs(ranges).max() if not look.signed else ranges[:, 1].max()
        factor, label = look.shown_stress
        numbers = [even(factor * value, factor * look.stress_limit / 100) for value in (low, high)]
        words.append(f"{look.stress_name} {f'{numbers[0]} to' if look.signed else 'up to'} {numbers[1]} {label}")
    return words
