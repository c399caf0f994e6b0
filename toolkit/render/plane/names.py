"""Names of points in the axes that show them, where they cover nothing that is drawn."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, TriMesh

from toolkit.render.body_places import body_places
from toolkit.render.colors import BODY, INK, UNDEFORMED
from toolkit.render.label_places import Name, panel_of, placed, sides
from toolkit.render.moment import names_by_place
from toolkit.render.motion.names import NamesOfMotion
from toolkit.render.plane.configuration import Configuration
from toolkit.render.plane.skin_shape import skin_shape
from toolkit.render.plane.solid_shape import solid_shape
from toolkit.render.plane.symbols import clamps
from toolkit.render.plane.window import figure_of, shown

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
