"""Names of points in the axes that show them, where they cover nothing that is drawn."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import TriMesh

from toolkit.render.colors import INK
from toolkit.render.label_places import Name, beside
from toolkit.render.moment import names_by_place
from toolkit.render.plane.configuration import Configuration
from toolkit.render.plane.symbols import clamps
from toolkit.render.plane.window import figure_of, shown

_SIZE = 10
"""Of letters, in points."""
_CLEAR = {"boxstyle": "square,pad=0.05", "facecolor": "white", "edgecolor": "none", "alpha": 0.7}
_APART = 3e-3
"""Points nearer to each other share a label, relative to the window."""


def write_names(axes: Axes, moment: Configuration) -> None:
    """Name the points that the axes of a figure that is settled show; a light ground keeps a name readable where no place is free."""
    dots, tolerance = figure_of(axes).dpi / 72, _APART * float(np.ptp(shown(axes), axis=0).max())
    low, high = axes.bbox.get_points() / dots
    named = [(text, axes.transData.transform(place) / dots - low) for place, text in _labels(moment, tolerance)]
    texts: dict[str, Any] = {}
    for text, _ in named:
        texts[text] = axes.annotate(
            text, (0, 0), xycoords="axes points", fontsize=_SIZE, color=INK, ha="center", va="center", parse_math=False, zorder=4,
            bbox=_CLEAR, in_layout=False,
        )  # fmt: skip
    names = [Name(text, place, texts[text].get_window_extent().size / dots / 2) for text, place in named]
    lines = [line / dots - low for line in drawn_lines(axes)]
    placed = {name.text: place for name, place in beside(names, lines, _SIZE, high - low)}
    for text, written in texts.items():
        if text in placed:
            written.set_position(placed[text])
        else:
            written.remove()


def drawn_lines(axes: Axes) -> list[np.ndarray]:
    """Everything that is drawn in axes as polylines (n, 2), in pixels of the figure."""
    found = [line.get_transform().transform(line.get_xydata()) for line in axes.lines]
    for each in axes.collections:
        if isinstance(each, TriMesh):  # its edges are drawn as well
            continue
        (offset,) = each.get_offset_transform().transform(np.reshape(each.get_offsets(), (-1, 2)))
        found += [each.get_transform().transform(path.vertices) + offset for path in each.get_paths()]
    return found


def _labels(moment: Configuration, tolerance: float) -> list[tuple[np.ndarray, str]]:
    """Names of points, and which body is clamped where no named point is."""
    named = names_by_place(moment, tolerance)
    for body, points in clamps(moment).items():
        if not any(np.hypot(*(points[0] - place)) < tolerance for place, _ in named):
            named.append((points[0], f"{body} clamped"))
    return named
