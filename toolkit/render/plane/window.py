"""Windows on the plane: what axes show, x and y to one scale."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from toolkit.foundation.units import unit
from toolkit.render.plane.configuration import Configuration
from toolkit.render.round_numbers import tick_step
from toolkit.render.sheet import settle

Windows = dict[Axes, np.ndarray]
"""Axes -> corners (2, 2), lower left and upper right, of what they have to show."""
_MARGIN = 0.14
"""Round what is shown, relative to half of its extent: room for names of joints and for the thickness of bands."""
_LEAST = np.array([0.5, 0.2])
"""Width and height at least, relative to the larger of both: room for a title, and for names above and below a line."""
_TICKS = 0.45
"""Distance of ticks at least, in inches: room for the number of each."""
_BESIDE = 0.3
"""Distance of ticks along x from the sides at least, in steps of ticks."""
_THINNEST = 0.016
"""Thickness at which the two colours of a band can be told apart, relative to the window."""


def window(points: np.ndarray) -> np.ndarray:
    """Corners (2, 2), lower left and upper right, of a window that shows points (n, 2) with a margin."""
    low, high = points.min(axis=0), points.max(axis=0)
    half, middle = (high - low) / 2, (high + low) / 2
    extent = float(half.max()) or 1.0
    half = np.maximum(half, _LEAST * extent) + _MARGIN * extent
    return np.array([middle - half, middle + half])


def aspect(corners: np.ndarray) -> float:
    """Width of a window over its height."""
    wide, high = corners[1] - corners[0]
    return float(wide / high)


def panel_height(corners: np.ndarray, width: float) -> float:
    """Height in inches at which a panel in a column of that width, with labels on its left, has one scale for x and y."""
    return min((width - 0.9) / aspect(corners), 1.3 * width)


def open_windows(figure: Figure, moment: Configuration, windows: Windows, columns: int = 0, like: Figure | None = None) -> None:
    """Show windows with x and y to one scale, and lay the figure out for good; a window grows where its panel has room.

    With `columns` all windows are the same, so many beside each other, and only the lower and the left ones have numbers. What is laid out
    `like` another figure has its axes in the same places.
    """
    length = unit(moment.scene.units, "length")
    for k, (axes, corners) in enumerate(windows.items()):
        lowest, leftmost = not columns or k + columns >= len(windows), not columns or k % columns == 0
        axes.set(xlim=corners[:, 0], ylim=corners[:, 1], xlabel=f"x in {length}" * lowest, ylabel=f"y in {length}" * leftmost)
        axes.tick_params(labelbottom=lowest, labelleft=leftmost)
        axes.set_axisbelow(True)
    settle(figure, lambda: _fit(windows), like)


def _fit(windows: Windows) -> None:
    for axes, corners in windows.items():
        size, room = np.ptp(corners, axis=0), axes.bbox.size
        half = room * (size / room).max() / 2
        (left, low), (right, high) = corners.mean(axis=0) - half, corners.mean(axis=0) + half
        axes.set(xlim=(left, right), ylim=(low, high))
        step = tick_step(_TICKS * figure_of(axes).dpi * 2 * half[0] / room[0])
        room_of_number = step * np.array([_BESIDE, 0.0])  # the number of a tick at the side would run into that of the next panel
        ends = shown(axes) + np.array([[1], [-1]]) * room_of_number
        for axis, low, high in zip((axes.xaxis, axes.yaxis), *ends / step, strict=True):
            ticks = step * (np.arange(np.ceil(low), np.floor(high) + 1) + 0.0)  # no -0.0
            axis.set_major_locator(FixedLocator(ticks.tolist()))


def figure_of(axes: Axes) -> Figure:
    """Figure that axes are on."""
    found = axes.figure
    return found if isinstance(found, Figure) else found.figure  # Not get_figure(root=True), which matplotlib 3.9 lacks.


def shown(axes: Axes) -> np.ndarray:
    """Corners (2, 2) of the window that axes show."""
    return np.transpose([axes.get_xlim(), axes.get_ylim()])


def drawn_thickness(true: float, corners: np.ndarray) -> float:
    """Thickness of a skin in a window, or more if its two colours could not be told apart."""
    return max(true, _THINNEST * float(np.ptp(corners, axis=0).max()))
