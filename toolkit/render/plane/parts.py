"""The parts of a planar scene in axes of matplotlib: skins coloured by a field, outlines, rods, joints and supports."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection, TriMesh
from matplotlib.colors import Normalize
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.tri import Triangulation

from toolkit.components.bodies.cut_body import CutBody
from toolkit.components.joints.joint import Joint
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.rigid_joint import RigidJoint, Tie
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.springs import SpringDamper
from toolkit.foundation.kinematics.orientation import unit_vector
from toolkit.render.moment import POINT
from toolkit.render.plane.configuration import Configuration, SolidShape, drawn_model, skin_shape, solid_shape
from toolkit.render.plane.look import Look, drawn_thickness, figure_of, shown
from toolkit.render.readable_units import INK, ROD, SUPPORT, TARGET, UNDEFORMED
from toolkit.render.sheet import SIGNED

if TYPE_CHECKING:
    from matplotlib.typing import ColorType

_ALONG_X = np.array([1.0, 0.0])


class Symbol(NamedTuple):
    """A symbol at a point (2,), its own x axis along a direction (2,)."""

    kind: str
    point: np.ndarray
    direction: np.ndarray = _ALONG_X

    def lines(self, size: float) -> list[np.ndarray]:
        """Polylines (n, 2) that draw the symbol around its point."""
        c, s = self.direction
        return [size * corners @ np.array([[c, s], [-s, c]]) for corners in _LINES[self.kind]]


def symbols(configuration: Configuration) -> list[Symbol]:
    """Symbols of pins, sliders, supports, clamps and masses of a scene.

    What turns freely has a pin, what is fixed to the ground a hatched side.

    A named point that none of these stands at is a dot.
    """
    found = [symbol for joint in configuration.joints() for symbol in _joint_symbols(configuration, joint)]
    for link in configuration.links():
        for (body, _), end in zip(link.grips, configuration.ends(link), strict=True):
            found += [Symbol("pin", end)] + [Symbol("support", end)] * (body == "ground")
    found += [Symbol("clamp", point) for points in clamps(configuration).values() for point in points]
    return found + [Symbol("point", point) for point in configuration.bare_points([each.point for each in found])]


def clamps(configuration: Configuration) -> dict[str, np.ndarray]:
    """Clamped nodes (n, 2) of every grounded flexible body, n > 0.

    They are those that no elastic coordinate moves, or that tie cut bodies to the ground.
    """
    ties = [each for each in configuration.scene.joints.values() if isinstance(each, Tie) and "ground" in each.bodies]
    found = {}
    for body in configuration.flexible():
        mesh = drawn_model(configuration, body).mesh
        if mesh is not None and not configuration.scene.body(body).has_frame:
            still = ~np.any(mesh.recovery[:, 1:].reshape(len(mesh.nodes), -1), axis=1)
            found[body] = configuration.place(body, mesh.nodes[still])
        if isinstance(configuration.scene.body(body), CutBody):
            held = [configuration.ends(tie)[0] for tie in ties if body in tie.bodies]
            found[body] = np.reshape(held, (-1, 2))
    return {body: points for body, points in found.items() if len(points)}


def _joint_symbols(configuration: Configuration, joint: Joint) -> list[Symbol]:
    """Symbols of one joint.

    A slider is drawn where its point is now, along the axis of the body that carries it; any new kind of joint is a pin.
    """
    point, grounded = configuration.ends(joint)[0], "ground" in joint.bodies
    if isinstance(joint, RigidJoint):
        alone = any(_is_a_point(configuration, body) for body in joint.bodies if body != "ground")
        return [Symbol("clamp", point)] if grounded else [Symbol("mass", point)] * alone
    if isinstance(joint, Slider):
        axis = configuration.turned(*joint.grips[1], unit_vector(np.real(joint.axis)))
        rails = Symbol("grounded slider" if grounded else "slider", point, axis)
        return [rails] if joint.lock_rotation else [rails, Symbol("pin", point)]
    return [Symbol("pin", point)] + [Symbol("support", point)] * (grounded and isinstance(joint, Revolute))


def _is_a_point(configuration: Configuration, body: str) -> bool:
    """Whether a body is drawn as nothing but a point: a mass that is fixed to another body at its centre."""
    lines, size = configuration.segments(body), configuration.scene.size
    return bool(lines) and all(np.ptp(line, axis=0).max() < POINT * size for line in lines)


def _hatched(half: float, y: float, depth: float) -> list[np.ndarray]:
    """Line from (-half, y) to (half, y) with strokes on the solid side: below for a negative depth."""
    strokes = [np.array([[x, y], [x - 0.35, y + depth]]) for x in np.linspace(0.4 - half, half, 5)]
    return [np.array([[-half, y], [half, y]]), *strokes]


def _box(x: float, y: float) -> np.ndarray:
    return np.array([[-x, -y], [x, -y], [x, y], [-x, y], [-x, -y]])


_CIRCLE = np.linspace(0, 2 * np.pi, 17)
_LINES = {
    "pin": [0.5 * np.column_stack([np.cos(_CIRCLE), np.sin(_CIRCLE)])],
    "mass": [_box(0.6, 0.6)],
    "point": [0.22 * np.column_stack([np.cos(_CIRCLE), np.sin(_CIRCLE)])],
    "support": [np.array([[0.0, 0.0], [-0.6, -1.0], [0.6, -1.0], [0.0, 0.0]]), *_hatched(1.0, -1.0, -0.45)],
    "clamp": [_box(1.0, 1.0), *(np.array(ends) for ends in (((-1, 0), (0, 1)), ((-1, -1), (1, 1)), ((0, -1), (1, 0))))],
    "slider": [_box(0.9, 0.8), np.array([[-1.7, -1.1], [1.7, -1.1]]), np.array([[-1.7, 1.1], [1.7, 1.1]])],
    "grounded slider": [_box(0.9, 0.8), *_hatched(1.7, -1.1, -0.45), *_hatched(1.7, 1.1, 0.45)],
}


Dashes = Literal["-", "--"]
_SYMBOL = 6.5 / 72
"""Size of drawing symbols in inches, whatever the scale is."""
_SPRING = 4.0 / 72
"""Half width of a spring, in inches."""
_BAND = 4.0
"""Width of the coloured boundary of a meshed body, in points."""
_UNTOLD, _EDGE = "#c8cdd4", "#5d6f8a"
"""Colour where nothing is known of a field; colour of the edge of a rod."""
_SOLID, _ROD, _SKIN, _OUTLINE, _TARGET, _LINE, _SUPPORT, _PIN = 1.4, 1.5, 2.0, 2.2, 2.4, 2.3, 3.0, 3.2
"""What covers what."""


def draw_band(axes: Axes, moment: Configuration, body: str, fibres: np.ndarray, colors: Normalize, thickness: float) -> None:
    """Draw a skin as two bands, outer and inner fibre, coloured by values (n_e, POINTS, 2).

    The skin is drawn thicker than it is, if it could not be seen.

    Every value has a piece of its own, round its point, so that the extremes of the values are seen.
    """
    shape = skin_shape(moment, body)
    if shape is None:
        return
    outer = shape.fibres(drawn_thickness(thickness, shown(axes)))  # (n_e, POINTS, fibre, 2)
    edge, middle = (_pieces(points) for points in (outer, np.broadcast_to(shape.line[:, :, None], outer.shape)))
    corners = np.stack([edge[:, :-1], edge[:, 1:], middle[:, 1:], middle[:, :-1]], axis=3)  # (n_e, POINTS, fibre, 4, 2)
    look: Any = {"cmap": colormaps[SIGNED].with_extremes(bad=_UNTOLD), "norm": colors, "edgecolors": "face", "linewidths": 0.2}
    axes.add_collection(PolyCollection(list(corners.reshape(-1, 4, 2)), array=fibres.ravel(), zorder=_SKIN, **look))
    edges = list(np.moveaxis(outer, 2, 0).reshape(-1, outer.shape[1], 2))
    axes.add_collection(LineCollection(edges, colors=INK, linewidths=0.4, zorder=_SKIN))


def _pieces(points: np.ndarray) -> np.ndarray:
    """Borders (n_e, POINTS + 1, ...) between the pieces of a line that belong to its points."""
    return np.concatenate([points[:, :1], (points[:, 1:] + points[:, :-1]) / 2, points[:, -1:]], axis=1)


def draw_solid(axes: Axes, shape: SolidShape, colors: Normalize) -> None:
    """Draw a meshed body with the stress inside, or along its boundary alone, or without colours, as its model allows."""
    section, inside = _section(shape.edges), shape.inside
    if inside is not None:
        mesh = Triangulation(inside.points[:, 0], inside.points[:, 1], inside.triangles)
        shades = TriMesh(mesh, array=inside.stress, cmap=SIGNED, norm=colors, zorder=_SOLID)
        shades.set_rasterized(True)  # SVG and PDF have no shades between three points
        axes.add_collection(shades)
        axes.add_patch(PathPatch(section, fill=False, edgecolor=INK, linewidth=0.8, zorder=_SOLID))
        return
    axes.add_patch(PathPatch(section, facecolor=_UNTOLD, edgecolor="none", zorder=_SOLID))
    if np.isnan(shape.stress).all():
        return
    edges = list(shape.edges)
    look: Any = {"capstyle": "round", "zorder": _SKIN}
    known: Any = {"cmap": colormaps[SIGNED].with_extremes(bad=_UNTOLD), "norm": colors, **look}
    axes.add_collection(LineCollection(edges, colors=INK, linewidths=_BAND + 0.8, **look))
    axes.add_collection(LineCollection(edges, array=shape.stress, linewidths=_BAND, **known))


def draw_sections(axes: Axes, moment: Configuration, bodies: Collection[str], edge: str = INK, filled: bool = False) -> None:
    """Draw meshed bodies without their stress."""
    for body in bodies:
        shape = solid_shape(moment, body)
        if shape is not None:
            look: Any = {"edgecolor": edge, "facecolor": _UNTOLD if filled else "none", "linewidth": 0.8}
            axes.add_patch(PathPatch(_section(shape.edges), zorder=_SOLID, **look))


def _section(edges: np.ndarray) -> Path:
    """Closed path around the area that edges (n_edges, n_points, 2), one after the other, enclose."""
    lines = _closed(edges)
    codes = [np.array([Path.MOVETO, *[Path.LINETO] * (len(line) - 2), Path.CLOSEPOLY], Path.code_type) for line in lines]
    return Path(np.concatenate(lines), np.concatenate(codes))


def _closed(edges: np.ndarray) -> list[np.ndarray]:
    """Closed lines (n, 2) from edges (n_edges, n_points, 2) that follow one another."""
    starts = np.flatnonzero(np.append(True, np.any(edges[1:, 0] != edges[:-1, -1], axis=1)))
    return [np.vstack([piece[:, :-1].reshape(-1, 2), piece[-1:, -1]]) for piece in np.split(edges, starts[1:])]


def draw_outlines(axes: Axes, moment: Configuration, body: str, look: Look) -> None:
    """Draw the undeformed and the target contour of a body in its place."""
    for label, points, color, dashes, order in outlines(moment, body, look):
        axes.plot(*points.T, dashes, color=color, linewidth=1.2, label=label, zorder=order)


def outlines(moment: Configuration, body: str, look: Look) -> list[tuple[str, np.ndarray, str, Dashes, float]]:
    """Contours of a body that are drawn: kind, points (n, 2), colour, dashes and drawing height of each."""
    mesh = drawn_model(moment, body).mesh
    if mesh is None:
        return []
    every: tuple[tuple[str, np.ndarray, str, Dashes, float], ...] = (
        ("undeformed", mesh.outline, UNDEFORMED, "-", _OUTLINE),
        ("target", mesh.target_outline, TARGET, "--", _TARGET),
    )
    return [
        (label, moment.place(body, line), color, dashes, order)
        for label, line, color, dashes, order in every
        if len(line) > 1 and (label == "target" or body in look.left)
    ]


def draw_line(axes: Axes, moment: Configuration, body: str, color: ColorType, width: float, label: str | None = None) -> None:
    """Draw the middle line of a skin."""
    shape = skin_shape(moment, body)
    if shape is not None:
        axes.plot(*shape.line.reshape(-1, 2).T, zorder=_LINE, color=color, linewidth=width, label=label)


def draw_mechanism(
    axes: Axes, moment: Configuration, color: str = ROD, edge: str = _EDGE, width: float = 4.0, but: Collection[str] = ()
) -> None:
    """Draw rigid bodies as thick lines with edges, springs as zigzags, distance joints and wheels as thin lines.

    Bodies that are drawn already are left out.
    """
    rods = [ends for ends in moment.rods(but) for _ in ("edge", "inside")]
    springs = [each for each in moment.links() if isinstance(each, SpringDamper)]
    links = [*(moment.ends(each) for each in moment.links() if each not in springs), *moment.wheels()]
    axes.add_collection(LineCollection(links, colors=color, linewidths=1.5, zorder=_ROD))
    look: Any = {"colors": (edge, color), "linewidths": (width + 1.0, width)}
    axes.add_collection(LineCollection(rods, capstyle="round", zorder=_ROD, **look))
    half = _SPRING * float(np.ptp(axes.get_xlim())) / (axes.bbox.width / figure_of(axes).dpi)
    coils = [zigzag(moment.ends(each), half) for each in springs]
    axes.add_collection(LineCollection(coils, colors=edge, linewidths=1.5, zorder=_ROD, gid="springs"))


def zigzag(ends: np.ndarray, half: float, teeth: int = 8) -> np.ndarray:
    """Points (n, 2) of a spring between two ends (2, 2), straight at both, and so far to each side of the line between them."""
    along = ends[1] - ends[0]
    aside = np.array([-along[1], along[0]]) / max(float(np.hypot(*along)), np.finfo(float).tiny)
    places, sides = np.linspace(0.2, 0.8, 2 * teeth + 1), np.zeros(2 * teeth + 1)
    sides[1::4], sides[3::4] = half, -half
    return np.vstack([ends[0], ends[0] + np.outer(places, along) + np.outer(sides, aside), ends[1]])


def draw_symbols(axes: Axes, moment: Configuration) -> None:
    """Draw pins as circles, masses as squares, points as dots, all else as lines, of one size on paper."""
    filled = {"pin": "white", "mass": ROD, "point": INK}
    for symbol in symbols(moment):
        fill = filled.get(symbol.kind)
        kind: Any = PolyCollection if fill else LineCollection
        look: Any = {"facecolors": fill, "edgecolors": INK, "zorder": _PIN} if fill else {"colors": SUPPORT, "zorder": _SUPPORT}
        place = {"offsets": [symbol.point], "offset_transform": axes.transData}
        drawn = kind(symbol.lines(_SYMBOL), linewidths=1.3, capstyle="round", gid=symbol.kind, **look, **place)
        drawn.set_transform(figure_of(axes).dpi_scale_trans)
        axes.add_collection(drawn)
