"""Pictures of a scene in space: one instant, or several instants beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pyvista

from toolkit.components.loads.gravity import SpatialGravity
from toolkit.components.loads.springs import SpatialSpringDamper
from toolkit.foundation.near_ties import first_smallest
from toolkit.foundation.units import unit
from toolkit.render.label_places import Name, NamesOfMotion, Panel, Side, body_places, panel_of, placed, sides
from toolkit.render.moment import names_by_place
from toolkit.render.readable_units import BODY, INK, ROD, SUPPORT, UNDEFORMED, even, readable, round_off, told
from toolkit.render.sheet import SIGNED, UNSIGNED
from toolkit.render.space import parts
from toolkit.render.space.configuration import BOX_EDGES, SpatialConfiguration, body_shape, drawn_as_built, stress_extremes
from toolkit.render.space.look import ARROW, ISOMETRIC, Camera, SpatialLook, arrows, natural_aspect, rod_radius
from toolkit.render.space.parts import SpatialSymbol, spatial_symbols
from toolkit.render.space.plotter import (
    AXES,
    SHINE,
    Place,
    SpatialPanel,
    Style,
    canvas,
    color_bar,
    explain,
    head_line,
    letter,
    overview_places,
    strokes,
)
from toolkit.responses.stress import point_stress

JOINT, UNTOLD = "#3a3f47", "#c8cdd4"
LOADS = {"force": "#8e2a9e", "torque": "#d2691e"}
_REACHES = (0.4, 0.7, 1.1, 1.6, 2.5, 3.5, 5.0, 7.0, 10.0)
"""Gaps between a point and its name, in letters: a name of a large body has to leave it."""
SMALLEST = 1e-3
"""Part of the largest force or torque below which one is not drawn."""
_MOVED = 0.25
"""Part of a tube's radius: a body that has moved less hides its undeformed shape."""


def draw_spatial_scene(
    panel: SpatialPanel, moment: SpatialConfiguration, look: SpatialLook, motion: NamesOfMotion | None = None
) -> pyvista.Actor | None:
    """Draw everything at one instant into a panel; returns the actor that the colour bar belongs to, or None."""
    _draw_undeformed(panel, moment, look)
    actor = _draw_bodies(panel, moment, look)
    _draw_rods(panel, moment, look)
    _draw_links(panel, moment, look)
    _draw_symbols(panel, moment, look)
    _draw_arrows(panel, moment, look)
    if look.view.triads:
        _draw_triads(panel, moment, look)
    _write_names(panel, moment, look, motion)
    return actor


def has_moved(moment: SpatialConfiguration, look: SpatialLook) -> bool:
    """Whether any body is so far from its undeformed place that both places are drawn."""
    start = SpatialConfiguration.undeformed(moment.solution)
    pairs = [(body_shape(start, body).points, body_shape(moment, body).points) for body in look.bodies]
    pairs += [pair for body in moment.scene.bodies for pair in zip(start.segments(body), moment.segments(body), strict=True)]
    return any(_apart(before, now, look) for before, now in pairs)


def _apart(before: np.ndarray, now: np.ndarray, look: SpatialLook) -> bool:
    return bool(np.abs(before - now).max(initial=0) >= _MOVED * look.radius)


def _draw_undeformed(panel: SpatialPanel, moment: SpatialConfiguration, look: SpatialLook) -> None:
    """Draw bodies that have moved in their undeformed places, faint and behind everything else."""
    start, draw = SpatialConfiguration.undeformed(moment.solution), partial(panel.draw_back, color=UNDEFORMED, lighting=False)
    for body in look.bodies:
        shape = body_shape(start, body)
        if not _apart(shape.points, body_shape(moment, body).points, look):
            continue
        if len(shape.triangles) or shape.sides:
            draw(parts.surface(shape), opacity=0.12)
        if len(shape.triangles):
            draw(parts.edges(shape), opacity=0.5)
        if len(shape.lines):
            draw(parts.fibres(shape), opacity=0.5)
    for body in moment.scene.bodies:
        for before, now in zip(start.segments(body), moment.segments(body), strict=True):
            if _apart(before, now, look):
                draw(parts.rod(before, 0.6 * look.radius), opacity=0.25)


def _draw_bodies(panel: SpatialPanel, moment: SpatialConfiguration, look: SpatialLook) -> pyvista.Actor | None:
    """Draw the flexible bodies with their stress, clamped places in the colour of supports."""
    actor, limit = None, look.shown_stress.factor * look.stress_limit or 1.0
    style: Style = {**SHINE, "scalars": parts.STRESS, "nan_color": UNTOLD}
    style["cmap"], style["clim"] = (SIGNED, (-limit, limit)) if look.signed else (UNSIGNED, (0.0, limit))
    for body in look.bodies:
        shape = body_shape(moment, body)
        values = look.colored(shape) if look.stress_limit else np.full(len(shape.points), np.nan)
        if len(shape.triangles) or shape.sides:
            actor = panel.draw(parts.surface(shape, values), **style)
        if len(shape.triangles):
            panel.draw_nearer(parts.edges(shape), 1.0 * look.radius, color="black", opacity=0.6, lighting=False)
        if len(shape.lines):
            share = 0.2 if shape.sides else 0.6
            actor = panel.draw(parts.fibres(shape, values).tube(radius=share * look.radius, n_sides=12), **style)
        if moment.spatial_body(body).frame == "grounded" and (fixed := parts.clamped_faces(shape)).n_cells:
            panel.draw_nearer(fixed, 0.1 * look.radius, color=SUPPORT, **SHINE)
    return actor


def _draw_rods(panel: SpatialPanel, moment: SpatialConfiguration, look: SpatialLook) -> None:
    """Draw rigid bodies: rods, stars with a ball at the centre of mass, or the edges of a box."""
    for body in moment.scene.bodies:
        segments, boxed = moment.segments(body), len(moment.segments(body)) == BOX_EDGES
        radius = 0.5 * look.radius if boxed else rod_radius(moment, body, look.radius)
        for ends in segments:
            panel.draw(parts.rod(ends, radius), color=ROD, smooth_shading=True)
        if moment.has_ball(body):
            panel.draw(parts.ball(moment.centre(body), 2 * look.radius), color=ROD, smooth_shading=True)


def _draw_links(panel: SpatialPanel, moment: SpatialConfiguration, look: SpatialLook) -> None:
    """Draw springs as coils, other components between two points and wheels as thin rods."""
    for wheel in moment.wheels():
        panel.draw(parts.rod(wheel, 0.4 * look.radius), color=JOINT, smooth_shading=True)
    for link in moment.links():
        ends = moment.ends(link)
        points = parts.coil(ends, 1.6 * look.radius) if isinstance(link, SpatialSpringDamper) else ends
        panel.draw(parts.rod(points, 0.4 * look.radius), color=JOINT, smooth_shading=True)


def _draw_symbols(panel: SpatialPanel, moment: SpatialConfiguration, look: SpatialLook) -> None:
    """Draw joints and grounds, before everything else."""
    for symbol in spatial_symbols(moment):
        color = SUPPORT if symbol.grounded else JOINT
        opacity = 0.5 if symbol.kind == "plane" else 1.0
        panel.draw_front(symbol.surface(1.3 * look.radius), color=color, opacity=opacity, **SHINE)


def _draw_arrows(panel: SpatialPanel, moment: SpatialConfiguration, look: SpatialLook) -> None:
    """Draw forces and torques as arrows, the longer the larger."""
    for kind, point, vector in arrows(moment):
        relative = float(np.linalg.norm(vector)) / (look.largest[kind] or 1.0)
        if relative >= SMALLEST:
            whole = vector / look.largest[kind] * ARROW * look.extent
            mesh = parts.arrow(point, whole, look.radius * min(1.0, 0.3 + relative), 2 if kind == "torque" else 1)
            panel.draw_front(mesh, color=LOADS[kind], **SHINE)


def _draw_triads(panel: SpatialPanel, moment: SpatialConfiguration, look: SpatialLook) -> None:
    """Draw the axes of the bodies' frames."""
    for body in moment.scene.pieces():
        origin, axes = moment.frame(body)
        for direction, color in zip(axes.T, AXES.values(), strict=True):
            panel.draw_front(parts.arrow(origin, direction * look.extent / 14, 0.5 * look.radius, 1), color=color, **SHINE)


def _write_names(panel: SpatialPanel, moment: SpatialConfiguration, look: SpatialLook, motion: NamesOfMotion | None) -> None:
    """Write names of points, in the first panel of bodies too, off everything that is drawn.

    A line leads to a name that is not beside its point.
    """
    named = names_by_place(moment, look.radius / 2, motion.moments if motion else ())
    bodies = _middles(moment, look, panel, motion) if panel.number == 1 else []
    names = [
        Name(name, panel.pixel(point), panel.letter * np.array([0.3 * len(name) + 0.1, 0.5])) for point, name in [*named, *bodies]
    ]
    seen = panel_of(names, [], panel.letter, np.array(panel.place[2:]), panel.covered())

    def choose(panels: Sequence[Panel]) -> list[Side]:
        return sides(panels, panel.letter, _REACHES)

    found = placed(seen, choose([seen]) if motion is None else motion.sides(panel.number, seen, choose))
    for each, color in zip(found, [INK] * len(named) + [BODY] * len(bodies), strict=True):
        if each is None:
            continue
        panel.write(each.name.text, each.place, color)
        if each.led:
            panel.plotter.subplot(0, panel.number)
            strokes(panel.plotter, [each.line], UNDEFORMED, 1.0)


def _middles(
    moment: SpatialConfiguration, look: SpatialLook, panel: SpatialPanel, motion: NamesOfMotion | None
) -> list[tuple[np.ndarray, str]]:
    """A place near the middle of every body with its name, unless a point has that name already."""
    found, places = [], body_places(moment, panel.pixel, motion.moments if motion else ())
    for body in (name for name in moment.scene.bodies if name not in moment.named_points()):
        if body in look.bodies:
            shape = body_shape(moment, body)
            pieces = np.vstack([shape.points[each].mean(axis=1) for each in (shape.triangles, shape.lines)])
            found.append((pieces[first_smallest(np.linalg.norm(pieces - shape.points.mean(axis=0), axis=1))], body))
        elif body in places:
            found.append((places[body], body))
    return found


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
    plotter: pyvista.Plotter,
    actor: pyvista.Actor | None,
    moments: Sequence[SpatialConfiguration],
    look: SpatialLook,
    left: int,
    letters: int,
) -> None:
    """Colour bar at the lower left, meaning of colours beside it or in its place, symbols above."""
    words = 0.62 * plotter.window_size[0] if look.stress_limit else left
    if actor is not None and look.stress_limit:
        color_bar(plotter, actor, f"{look.stress_name} in {look.shown_stress.label}", letters)
    found = [(f"faint: {_faint(moments[0], look)}", UNDEFORMED)] if any(has_moved(moment, look) for moment in moments) else []
    explain(plotter, [*found, *_loads(moments, look), (_scale(moments[0], look), INK)], words, letters)
    _draw_symbol_words(plotter, moments[0], left, letters, foot(moments[0], look) - _ABOVE)


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


def _draw_symbol_words(plotter: pyvista.Plotter, moment: SpatialConfiguration, left: int, letters: int, top: float) -> None:
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
            fitted = (
                mesh.translate(-(low + high) / 2).scale(_ICON * letters / float(np.linalg.norm(high - low))).translate(middle)
            )
            panel.draw(fitted, color=color, **SHINE)
        letter(plotter, SYMBOLS[kind][0], pixel + np.array([1.2 * letters, 0.0]), letters, INK, ("left", "center"))


def _icon(kind: str, grounded: dict[str, bool]) -> list[tuple[pyvista.PolyData, str]]:
    """Surfaces that stand for a kind of symbol, and their colours."""
    if kind == "spring":
        return [(parts.rod(parts.coil(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 8.0]]), 1.6, turns=4), 0.4), JOINT)]
    drawn = [SpatialSymbol(each, np.zeros(3), np.eye(3), grounded.get(each, False)) for each in (kind, *SYMBOLS[kind][1:])]
    return [(symbol.surface(1.0), SUPPORT if symbol.grounded else JOINT) for symbol in drawn]


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
    found = [load for load in moment.scene.loads.values() if isinstance(load, SpatialGravity)]
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
