"""What a picture of space explains below its panels: colours, arrows, and the symbols of joints and supports that it shows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from toolkit.foundation.units import unit
from toolkit.loads.springs import SpatialSpringDamper
from toolkit.render.colors import INK, SUPPORT, UNDEFORMED
from toolkit.render.readable_units import readable
from toolkit.render.space import parts
from toolkit.render.space.arrows import arrows
from toolkit.render.space.body_shape import drawn_as_built
from toolkit.render.space.camera import ISOMETRIC, Camera
from toolkit.render.space.configuration import SpatialConfiguration
from toolkit.render.space.drawing import JOINT, LOADS, SHINE, SMALLEST, has_moved
from toolkit.render.space.look import SpatialLook
from toolkit.render.space.plotter.layout import color_bar, explain
from toolkit.render.space.plotter.lettering import letter
from toolkit.render.space.plotter.panel import SpatialPanel
from toolkit.render.space.symbols import SpatialSymbol, spatial_symbols

SYMBOLS = {
    "ground": ("ground",),
    "weld": ("clamped",),
    "hinge": ("hinge",),
    "ball": ("ball joint",),
    "cross": ("universal joint",),
    "slider": ("slides on rails", "rails"),
    "sleeve": ("slides and turns", "rail"),
    "plane": ("stays on a plane",),
    "spring": ("spring",),
}
"""Kind of symbol -> what it is, and the kind that is drawn with it. A pin is the end of a link, and needs no word."""
_COLUMNS, _WIDE, _HIGH, _ICON = 4, 12.0, 1.8, 1.7
"""Symbols beside each other; width and height of an entry, and size of a symbol, in letters."""
_ROWS = 2
"""Rows of symbols at most."""
_BAR, _WORDS, _LEAST = 5.6, (0.7, 1.3), 8.0
"""Height below the symbols of a colour bar, of words and of each line of them, and of all that the axes beside them need, in letters."""
_ABOVE = 2.8
"""Height above the symbols, for the scale, in letters."""


def foot(moment: SpatialConfiguration, look: SpatialLook) -> float:
    """Height of all legends below the panels, in letters; the same at all instants of a motion."""
    rows = _ROWS if look.stress_limit else -(-len(_kinds(moment)) // _COLUMNS)
    return max(_LEAST, _ABOVE + _HIGH * rows + _below(look))


def _below(look: SpatialLook) -> float:
    """Height of the legends below the symbols, in letters."""
    return _BAR if look.stress_limit else _WORDS[0] + _WORDS[1] * (2 + sum(size > 0 for size in look.largest.values()))


def draw_legend(
    plotter: Any, actor: Any, moments: Sequence[SpatialConfiguration], look: SpatialLook, left: int, letters: int
) -> None:
    """Colour bar at the lower left, meaning of colours beside it or in its place, symbols above."""
    words = 0.62 * plotter.window_size[0] if look.stress_limit else left
    if actor is not None and look.stress_limit:
        color_bar(plotter, actor, f"{look.stress_name} in {look.shown_stress.label}", letters)
    found = [(f"faint: {_faint(moments[0], look)}", UNDEFORMED)] if any(has_moved(moment, look) for moment in moments) else []
    explain(plotter, [*found, *_loads(moments, look), (_scale(moments[0], look), INK)], words, letters)
    _draw_symbols(plotter, moments[0], left, letters, foot(moments[0], look) - _ABOVE)


def _scale(moment: SpatialConfiguration, look: SpatialLook) -> str:
    """Words on sizes that are drawn to scale."""
    as_built = [body for body in look.bodies if drawn_as_built(moment.scene, body)]
    return f"motion to scale; surface of {', '.join(as_built)} as built" if as_built else "motion and shape to scale"


def _faint(moment: SpatialConfiguration, look: SpatialLook) -> str:
    """Words for the undeformed bodies in their places."""
    solution = moment.solution
    if solution.names:
        return solution.names[0]
    starts_there = solution.steps and not has_moved(SpatialConfiguration(solution, 0), look)
    return "at the start" if starts_there else "as the scene is written"


def _loads(moments: Sequence[SpatialConfiguration], look: SpatialLook) -> list[tuple[str, str]]:
    """Kinds of arrows that are drawn, with the largest of the whole motion."""
    units, found = moments[0].scene.units, []
    drawn = {
        each.kind
        for moment in moments
        for each in arrows(moment)
        if np.linalg.norm(each.vector) > SMALLEST * look.largest[each.kind]
    }
    for kind, words in (("force", "force"), ("torque", "torque (two heads)")):
        if kind in drawn:
            factor, label = readable(look.largest[kind], unit(units, kind))
            found.append((f"{words}, largest {factor * look.largest[kind]:.4g} {label}", LOADS[kind]))
    return found


def _kinds(moment: SpatialConfiguration) -> list[str]:
    """Kinds of symbols in the picture, in the order of the legend."""
    found = {symbol.kind for symbol in spatial_symbols(moment)}
    springs = any(isinstance(link, SpatialSpringDamper) for link in moment.links())
    return [kind for kind in SYMBOLS if kind in found] + ["spring"] * springs


def _draw_symbols(plotter: Any, moment: SpatialConfiguration, left: int, letters: int, top: float) -> None:
    """Each kind of symbol in the picture once, small and with its word; they end `top` letters above the edge."""
    grounded, entries = {symbol.kind: symbol.grounded for symbol in spatial_symbols(moment)}, _kinds(moment)
    if not entries:
        return
    rows = -(-len(entries) // _COLUMNS)
    place = (left, round((top - rows * _HIGH) * letters), round(_COLUMNS * _WIDE * letters), round(rows * _HIGH * letters))
    size = np.array(place[2:], float)
    camera = Camera(np.zeros(3), size, 5 * size[0], size[0], False)
    panel = SpatialPanel(plotter, len(plotter.renderers) - 1, place, letters, camera)
    panel.open(framed=False)
    for k, kind in enumerate(entries):
        row, column = divmod(k, _COLUMNS)
        pixel = letters * np.array([1.0 + _WIDE * column, _HIGH * (rows - 0.5 - row)])
        middle = (pixel - size / 2) @ ISOMETRIC[:2]
        icon = _icon(kind, grounded)
        low, high = (extreme(np.vstack([mesh.points for mesh, _ in icon]), axis=0) for extreme in (np.min, np.max))
        for mesh, color in icon:
            fitted = mesh.translate(-(low + high) / 2).scale(_ICON * letters / np.linalg.norm(high - low)).translate(middle)
            panel.draw(fitted, color=color, **SHINE)
        letter(plotter, SYMBOLS[kind][0], pixel + np.array([1.2 * letters, 0.0]), letters, INK, ("left", "center"))


def _icon(kind: str, grounded: dict[str, bool]) -> list[tuple[Any, str]]:
    """Surfaces that stand for a kind of symbol, and their colours."""
    if kind == "spring":
        return [(parts.rod(parts.coil(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 8.0]]), 1.6, turns=4), 0.4), JOINT)]
    drawn = [SpatialSymbol(each, np.zeros(3), np.eye(3), grounded.get(each, False)) for each in (kind, *SYMBOLS[kind][1:])]
    return [(symbol.surface(1.0), SUPPORT if symbol.grounded else JOINT) for symbol in drawn]
