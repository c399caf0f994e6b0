"""Figures of a planar scene: one instant with its detail, or several instants beside each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, TriMesh
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from toolkit.components.bodies.cut_body import CutBody
from toolkit.components.bodies.flexible import Flexible
from toolkit.foundation.units import unit
from toolkit.render.label_places import Name, NamesOfMotion, body_places, panel_of, placed, sides
from toolkit.render.moment import names_by_place
from toolkit.render.plane.configuration import Configuration, skin_shape, solid_shape
from toolkit.render.plane.look import (
    Look,
    aspect,
    drawn_thickness,
    figure_of,
    open_windows,
    panel_height,
    shown,
    shown_stress,
    window,
)
from toolkit.render.plane.parts import clamps, draw_band, draw_mechanism, draw_outlines, draw_solid, draw_symbols, outlines
from toolkit.render.readable_units import (
    BODY,
    FRAME,
    INK,
    MINUS,
    UNDEFORMED,
    even,
    readable,
    readable_stress,
    round_off,
    stress_range,
    told,
)
from toolkit.render.sheet import SEEN, SIGNED, WIDE, Panels, draw_panels, merged, motion_panels, sheet
from toolkit.responses.shape_error import gaps
from toolkit.system.solution import Solution, flexible_body

_SIZE = 10
"""Size of letters, in points."""
_NAME = 4.0
"""Above everything else."""
_CLEAR = {"boxstyle": "square,pad=0.05", "facecolor": "white", "edgecolor": "none", "alpha": 0.7}
_APART = 3e-3
"""Points nearer to each other share a label, relative to the window."""


def write_names(
    axes: Axes, moment: Configuration, bodies: bool = False, motion: NamesOfMotion | None = None, number: int = 0
) -> None:
    """Name the points, and on request the bodies, that the axes of a figure that is settled show.

    A light ground keeps a name readable where no place is free; a line leads to one that is not beside its point. In all pictures of a
    motion the axes of the same number have the same names on the same side of their points.
    """
    dots, tolerance = figure_of(axes).dpi / 72, _APART * float(np.ptp(shown(axes), axis=0).max())
    low, high = axes.bbox.get_points() / dots
    told = [(text, place, INK, "normal") for place, text in _labels(moment, tolerance, motion)]
    told += [(name, place, BODY, "italic") for name, place in _middles(moment, motion)] if bodies else []
    names, texts = [], []
    for text, place, color, slant in told:
        written: Any = axes.annotate(
            text, (0, 0), xycoords="axes points", fontsize=_SIZE, color=color, fontstyle=slant, ha="center", va="center",
            parse_math=False, zorder=_NAME, bbox=_CLEAR, in_layout=False,
        )  # fmt: skip
        names.append(Name(text, axes.transData.transform(place) / dots - low, written.get_window_extent().size / dots / 2))
        texts.append(written)
    panel = panel_of(names, [line / dots - low for line in drawn_lines(axes)], _SIZE, high - low)
    chosen = sides([panel], _SIZE) if motion is None else motion.sides(number, panel, lambda panels: sides(panels, _SIZE))
    leads = []
    for written, each in zip(texts, placed(panel, chosen), strict=True):
        if each is None:
            written.remove()
            continue
        written.set_position(each.place)
        if each.led:
            leads.append(axes.transData.inverted().transform((each.line + low) * dots))
    axes.add_collection(LineCollection(leads, colors=UNDEFORMED, linewidths=0.7, zorder=_NAME, gid="leads"), autolim=False)


def drawn_lines(axes: Axes) -> list[np.ndarray]:
    """All drawn contents of axes as polylines (n, 2), in pixels of the figure."""
    found = [line.get_transform().transform(line.get_xydata()) for line in axes.lines]
    for patch in axes.patches:
        found += map(np.asarray, patch.get_transform().transform_path(patch.get_path()).to_polygons())
    for each in axes.collections:
        if isinstance(each, TriMesh):  # its edges are drawn as well
            continue
        (offset,) = each.get_offset_transform().transform(np.reshape(each.get_offsets(), (-1, 2)))
        found += [each.get_transform().transform(path.vertices) + offset for path in each.get_paths()]
    return found


def _labels(moment: Configuration, tolerance: float, motion: NamesOfMotion | None) -> list[tuple[np.ndarray, str]]:
    """Names of points with their places, and a label for a clamped body where no named point is."""
    named = names_by_place(moment, tolerance, motion.moments if motion else ())
    for body, points in clamps(moment).items():
        if not any(np.hypot(*(points[0] - place)) < tolerance for place, _ in named):
            named.append((points[0], f"{body} clamped"))
    return named


def _middles(moment: Configuration, motion: NamesOfMotion | None) -> list[tuple[str, np.ndarray]]:
    """Names of bodies, each with a place near its middle; a body that is drawn as a point is named by that point."""
    found, places = [], body_places(moment, motion=motion.moments if motion else ())
    for body in moment.scene.bodies:
        if (skin := skin_shape(moment, body) if body in moment.flexible() else None) is not None:
            points = skin.line.reshape(-1, 2)
            found.append((body, points[len(points) // 2]))
        elif (solid := solid_shape(moment, body)) is not None:
            found.append((body, solid.deepest))
        elif body in places:
            found.append((body, places[body]))
    return found


def shape_errors(solution: Solution, body: str, steps: slice = slice(None)) -> np.ndarray | None:
    """Distance of every node to its target at every time, shape (n_t, n_k); None if the body has no target."""
    scene = solution.system.scene
    shape = scene.model(flexible_body(scene, body).model, "shape").shape
    if shape is None:
        return None
    return np.linalg.norm(np.real(gaps(solution, body, steps)[0]), axis=2)


def curves_figure(solution: Solution) -> Figure:
    """The curves, a panel per quantity."""
    return draw_panels(solution, _stress_panels(solution) + _shape_panels(solution) + _rotation_panels(solution))


def _flexible(solution: Solution) -> list[str]:
    return [name for name, body in solution.system.scene.bodies.items() if isinstance(body, Flexible)]


def _stress_panels(solution: Solution) -> Panels:
    curves: dict[str, Any] = {}
    for body in _flexible(solution):
        low, high = stress_range(solution, body).T
        curves |= {f"{body}, largest": high, f"{body}, smallest": low}
    return [("stress", "stress", curves)] if curves else []


def _shape_panels(solution: Solution) -> Panels:
    curves: dict[str, Any] = {}
    for body in _flexible(solution):
        errors = shape_errors(solution, body)
        if errors is not None:
            curves |= {f"{body}, largest": errors.max(axis=1), f"{body}, RMS": np.sqrt((errors**2).mean(axis=1))}
    return [("distance to target", "length", curves)] if curves else []


def _rotation_panels(solution: Solution) -> Panels:
    scene = solution.system.scene
    framed = [name for name, body in scene.bodies.items() if body.has_frame and not isinstance(body, CutBody)]
    curves = {name: np.real(solution.q[:, solution.coordinates(name).start + 2]) for name in framed}
    rotations: Panels = [("rotation", "angle", merged(curves))] if curves else []
    turned = any(np.abs(angle).max() > SEEN for angle in curves.values())
    return rotations if turned or not curves else _motion_panels(solution) or rotations


def _motion_panels(solution: Solution) -> Panels:
    moments = [Configuration(solution, step) for step in range(len(solution.times))]
    scene, points = solution.system.scene, moments[0].named_points()
    return motion_panels({point: np.real(scene.position(point)) for point in points}, moments)


def draw_scene(axes: Axes, moment: Configuration, look: Look) -> None:
    """Draw skins with their stress, outlines, mechanism, joints and supports in an open window, without names."""
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


COLUMNS, _TALLEST = 2, 5.0
"""Panels beside each other in an overview; height of a panel at most, in inches."""
_LINE = 0.22
"""Height of a line of letters, in inches."""
_BROAD = 8.0
"""Width in inches from which a legend stands in one line."""
_ALONG = "stress along the boundary of meshed bodies"
_INSIDE = "meshed bodies: von Mises stress, negative in compression"
_FRAME_MARGIN = 0.02
"""Round the frame of the detail at least, relative to the main window."""


def instant_figure(
    moment: Configuration, look: Look, width: float = WIDE, like: Figure | None = None, motion: NamesOfMotion | None = None
) -> Figure:
    """Figure of one instant: the scene and a detail where it moves most, laid out `like` another instant if given."""
    corners = instant_windows(look)
    ratios = [aspect(each) for each in corners]
    height = min((width - 0.9 * len(corners)) / sum(ratios), _TALLEST)
    with sheet(height + _room(look, 1, width), 1, len(corners), width, width_ratios=ratios) as (figure, axes):
        if look.detail is not None:
            axes[0, 1].set_title("detail (frame on the left)", loc="left")
        _fill(figure, axes, [moment] * len(corners), corners, look, like, motion)
        if look.detail is not None:
            low, high = shown(axes[0, 1])
            axes[0, 0].add_patch(Rectangle(low, *(high - low), fill=False, edgecolor=FRAME))
    return figure


def instants_alike(width: float = WIDE) -> Callable[[Configuration, Look, NamesOfMotion | None], Figure]:
    """Function that draws instants of a motion, one after the other, all laid out as the first, so that only the scene moves."""
    first: list[Figure] = []

    def figure(moment: Configuration, look: Look, motion: NamesOfMotion | None) -> Figure:
        found = instant_figure(moment, look, width, first[0] if first else None, motion)
        first[:] = first or [found]
        return found

    return figure


def instant_windows(look: Look) -> list[np.ndarray]:
    """Corners of the main window, and of the detail if there is one; the main window holds the frame of the detail."""
    main = window(look.points)
    if look.detail is None:
        return [main]
    margin = _FRAME_MARGIN * np.ptp(main, axis=0).max() * np.array([[-1], [1]])
    return [np.array([np.minimum(main, look.detail + margin)[0], np.maximum(main, look.detail + margin)[1]]), look.detail]


def overview_figure(moments: Sequence[Configuration], look: Look, width: float = WIDE, columns: int = COLUMNS) -> Figure:
    """Figure of several instants, with numbers at the ticks along the lower and left edge."""
    columns, corners = min(columns, len(moments)), window(look.points)
    rows = -(-len(moments) // columns)
    height = min(panel_height(corners, width / columns), _TALLEST)
    with sheet(rows * height + _room(look, rows, width), rows, columns, width) as (figure, axes):
        _fill(figure, axes, moments, [corners] * len(moments), look)
    return figure


def _room(look: Look, rows: int, width: float) -> float:
    """Height in inches of titles above rows of panels, and of ticks, colour bar and legend below."""
    lines = (1 + bool(look.thickness)) * rows + 2.5 + 1.5 * bool(look.solids)
    if look.stress_limit:
        lines += 2.5
    if look.thickness:
        lines += 1.5 if width > _BROAD else 3.5
    return lines * _LINE


def _fill(
    figure: Figure,
    axes: np.ndarray,
    moments: Sequence[Configuration],
    corners: list[np.ndarray],
    look: Look,
    like: Figure | None = None,
    motion: NamesOfMotion | None = None,
) -> None:
    """Draw a moment into each of the axes, in its window, with colour bar, legend and names where there is room."""
    windows = dict(zip(axes.flat, corners, strict=False))
    for panel, moment in zip(windows, moments, strict=True):
        words = caption(moment, look)
        title = "\n".join(",  ".join(line) for line in (words[:2], words[2:]) if line)
        panel.set_title(panel.get_title("left") or title.replace("-", MINUS), loc="left")
    for empty in list(axes.flat)[len(windows) :]:
        empty.remove()
    if look.stress_limit:
        factor, label = readable_stress(look.stress_limit, moments[0].scene.units)
        shown_colors = Normalize(-factor * look.stress_limit, factor * look.stress_limit)
        color_bar(figure, list(windows), shown_colors, f"stress in {label}")
    if entries := meanings(corners, look, moments[0]):
        figure.legend(handles=entries, loc="outside lower center", ncols=len(entries) if figure.get_figwidth() > _BROAD else 1)
    open_windows(figure, moments[0], windows, axes.shape[1] if all(each is corners[0] for each in corners) else 0, like)
    for legend in figure.legends:  # in windows that have grown
        for word, entry in zip(legend.get_texts(), meanings([shown(panel) for panel in windows], look, moments[0]), strict=True):
            word.set_text(str(entry.get_label()))
    for number, (panel, moment) in enumerate(zip(windows, moments, strict=True)):
        draw_scene(panel, moment, look)
        write_names(panel, moment, bodies=not number, motion=motion, number=number)


def color_bar(figure: Figure, axes: list[Axes], colors: Normalize, label: str, beyond: float = 0.0) -> None:
    """Add a colour bar below the axes; its ends are pointed where there are values beyond its colours."""
    bar = figure.colorbar(
        ScalarMappable(colors, SIGNED), ax=axes, location="bottom", label=label, aspect=50, shrink=0.7, pad=0.02,
        extend="both" if beyond else "neither",
    )  # fmt: skip
    bar.set_ticks(np.linspace(colors.vmin or 0.0, colors.vmax or 0.0, 5).tolist())


def caption(moment: Configuration, look: Look) -> list[str]:
    """Caption with time, range of the stress and, if one body has a target, the distance to it; digits suit the scene."""
    solution, step, units = moment.solution, moment.step, moment.scene.units
    words = [moment.told]
    stresses = [(name, each) for name, each in shown_stress(moment) if each.size and np.isfinite(each).all()]
    if any(told(each, round_off(moment.scene, name)) for name, each in stresses):
        every = np.concatenate([np.zeros(1), *(each.ravel() for _, each in stresses)])
        factor, label = readable_stress(look.stress_limit, units)
        low, high = (even(factor * value, factor * look.stress_limit / 100) for value in (every.min(), every.max()))
        words.append(f"stress {low} to {high} {label}")
    elif stresses:
        words.append("no stress")
    here = slice(step, step + 1)
    errors = [each[0] for body in look.thickness if (each := shape_errors(solution, body, here)) is not None]
    if len(errors) == 1:
        rms = float(np.sqrt((errors[0] ** 2).mean()))
        factor, label = readable(max(rms, look.extent * 1e-3), unit(units, "length"))
        words.append(f"RMS distance to target {even(factor * rms, factor * look.extent * 1e-5)} {label}")
    return words


def contour_keys(look: Look, moment: Configuration) -> list[Line2D]:
    """Legend entries for the contours that are drawn."""
    meant = {label: (color, dashes) for body in look.thickness for label, _, color, dashes, _ in outlines(moment, body, look)}
    return [Line2D([], [], color=color, linestyle=dashes, label=label) for label, (color, dashes) in meant.items()]


def meanings(windows: Sequence[np.ndarray], look: Look, moment: Configuration) -> list[Line2D]:
    """Legend entries for the lines and bands that are drawn, with the factor by which skins are thickened."""
    solids = _solid_keys(look, moment)
    if not look.thickness:
        return solids
    words = ["deformed, stress of outer and inner fibre" if look.stress_limit else "deformed", *_thicker(windows, look)]
    return [*contour_keys(look, moment), Line2D([], [], color=INK, linewidth=4, alpha=0.3, label="; ".join(words)), *solids]


def _thicker(windows: Sequence[np.ndarray], look: Look) -> list[str]:
    """Words telling by which factor windows show skins thicker than they are."""
    if not all(look.thickness.values()):
        return ["thickness not to scale"]
    factors = [max(drawn_thickness(true, corners) / true for true in look.thickness.values()) for corners in windows]
    main, *others = dict.fromkeys("to scale" if factor == 1 else f"{factor:.2g}-fold" for factor in factors)
    return [f"thickness {main}{''.join(f', in the detail {other}' for other in others)}"]


def _solid_keys(look: Look, moment: Configuration) -> list[Line2D]:
    """Legend entries that say how the stress of meshed bodies is shown."""
    shapes = [shape for body in look.solids if look.stress_limit and (shape := solid_shape(moment, body))]
    words = dict.fromkeys(_ALONG if shape.inside is None else _INSIDE for shape in shapes if np.isfinite(shape.shown).all())
    return [Line2D([], [], color=INK, linewidth=4, alpha=0.3, label=each) for each in words]
