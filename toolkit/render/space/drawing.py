"""A scene in space at one instant in one panel: bodies with their stress, rods, joints, supports, loads, names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from toolkit.foundation.near_ties import first_smallest
from toolkit.loads.springs import SpatialSpringDamper
from toolkit.render.body_places import body_places
from toolkit.render.colors import BODY, INK, ROD, SUPPORT, UNDEFORMED
from toolkit.render.label_places import Name, Panel, Side, panel_of, placed, sides
from toolkit.render.moment import names_by_place
from toolkit.render.motion.names import NamesOfMotion
from toolkit.render.sheet import SIGNED, UNSIGNED
from toolkit.render.space import parts
from toolkit.render.space.arrows import arrows
from toolkit.render.space.body_shape import body_shape
from toolkit.render.space.configuration import BOX_EDGES, SpatialConfiguration
from toolkit.render.space.look import ARROW, SpatialLook, rod_radius
from toolkit.render.space.plotter.lettering import strokes
from toolkit.render.space.plotter.panel import AXES, SpatialPanel
from toolkit.render.space.symbols import spatial_symbols

JOINT, UNTOLD = "#3a3f47", "#c8cdd4"
LOADS = {"force": "#8e2a9e", "torque": "#d2691e"}
SHINE: dict[str, Any] = {"ambient": 0.6, "diffuse": 0.4, "specular": 0.0}
"""Light that leaves colours readable."""
_REACHES = (0.4, 0.7, 1.1, 1.6, 2.5, 3.5, 5.0, 7.0, 10.0)
"""Gaps between a point and its name, in letters: a name of a large body has to leave it."""
SMALLEST = 1e-3
"""Part of the largest force or torque below which one is not drawn."""
_MOVED = 0.25
"""Part of a tube's radius: a body that has moved less hides its undeformed shape."""


def draw_spatial_scene(
    panel: SpatialPanel, moment: SpatialConfiguration, look: SpatialLook, motion: NamesOfMotion | None = None
) -> Any:
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
    start, faint = SpatialConfiguration.undeformed(moment.solution), {"color": UNDEFORMED, "lighting": False}
    for body in look.bodies:
        shape = body_shape(start, body)
        if not _apart(shape.points, body_shape(moment, body).points, look):
            continue
        if len(shape.triangles) or shape.sides:
            panel.draw_back(parts.surface(shape), opacity=0.12, **faint)
        if len(shape.triangles):
            panel.draw_back(parts.edges(shape), opacity=0.5, line_width=1, **faint)
        if len(shape.lines):
            panel.draw_back(parts.fibres(shape), opacity=0.5, line_width=1, **faint)
    for body in moment.scene.bodies:
        for before, now in zip(start.segments(body), moment.segments(body), strict=True):
            if _apart(before, now, look):
                panel.draw_back(parts.rod(before, 0.6 * look.radius), opacity=0.25, **faint)


def _draw_bodies(panel: SpatialPanel, moment: SpatialConfiguration, look: SpatialLook) -> Any:
    """Draw the flexible bodies with their stress, clamped places in the colour of supports."""
    actor, limit = None, look.shown_stress.factor * look.stress_limit or 1.0
    colors: dict[str, Any] = (
        {"cmap": SIGNED, "clim": (-limit, limit)} if look.signed else {"cmap": UNSIGNED, "clim": (0.0, limit)}
    )
    for body in look.bodies:
        shape = body_shape(moment, body)
        style: dict[str, Any] = {**colors, **SHINE, "scalars": parts.STRESS, "nan_color": UNTOLD}
        values = look.colored(shape) if look.stress_limit else np.full(len(shape.points), np.nan)
        if len(shape.triangles) or shape.sides:
            actor = panel.draw(parts.surface(shape, values), **style)
        if len(shape.triangles):
            panel.draw_nearer(parts.edges(shape), 1.0 * look.radius, color="black", opacity=0.6, line_width=1, lighting=False)
        if len(shape.lines):
            least = 0.2 if shape.sides else 0.6
            actor = panel.draw(parts.fibres(shape, values).tube(radius=least * look.radius, n_sides=12), **style)
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
