"""Maps of stability as a picture: the motion on the left, its gradient on the right, a letter and a colour for every class."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch, Rectangle

from toolkit.render.readable_units import MINUS
from toolkit.render.sheet import sheet
from toolkit.report.drawing import Drawing
from toolkit.studies.stability.cells import CLASSES
from toolkit.studies.stability.map_result import MapResult, Of, StabilityResult, verdicts
from toolkit.studies.stability.maps import Axis

CLASS_COLORS = ("#5ab4ac", "#f6e8c3", "#e69f00", "#b2450f", "#bdbdbd", "#ffffff")
"""Colours from light and cool to dark and warm: told apart by all kinds of colour vision, and in grey."""
LETTERS = ("", "i", "d", "F", "r", "")
DARK = ("failed",)
ROW, STRIP = 0.17, 0.30
"""Height of a row of a map over two axes, and of a map over one, in inches."""
AROUND = 0.72
"""Height of title and labels of a panel."""


def stability_drawing(study: StabilityResult, name: str) -> Drawing:
    """Drawing with one row of panels per map; without variables only the motion."""
    sides: tuple[Of, ...] = ("run", "gradient") if study.design else ("run",)
    heights = [_height(each) for each in study.maps]
    with sheet(
        sum(heights) + AROUND * len(heights) + 0.6, len(heights), len(sides), height_ratios=[h + 0.3 for h in heights]
    ) as (figure, axes):
        figure.set_figwidth(9.5 if len(sides) > 1 else 5.6)
        for row, each in zip(axes, study.maps, strict=True):
            for panel, of in zip(row, sides, strict=True):
                _panel(panel, each, of, labelled=of == "run")
        figure.legend(handles=_legend(study, sides), loc="outside lower center", ncols=len(CLASSES) + 1, handlelength=1.2)
    caption = "Each cell is one run: i, d, F and r stand for inaccurate, drifting, failed and refused; the frame is the scene as it stands."
    return Drawing("stability", f"Where {name} is stable", caption, figure)


def _height(mapped: MapResult) -> float:
    return ROW * len(mapped.map.axes[1].values) if len(mapped.map.axes) > 1 else STRIP


def _panel(panel: Axes, mapped: MapResult, of: Of, labelled: bool) -> None:
    """Coloured cells with letters; the scene's own place framed."""
    axes = mapped.map.axes
    numbers = np.full((len(axes[1].values) if len(axes) > 1 else 1, len(axes[0].values)), CLASSES.index("not run"))
    for at, verdict in verdicts(mapped, of).items():
        numbers[at[1] if len(at) > 1 else 0, at[0]] = CLASSES.index(verdict.name)
    panel.pcolormesh(
        numbers, cmap=ListedColormap(CLASS_COLORS), vmin=-0.5, vmax=len(CLASSES) - 0.5, edgecolors="white", linewidth=1.0
    )
    for (row, column), number in np.ndenumerate(numbers):
        color = "white" if CLASSES[number] in DARK else "black"
        panel.text(column + 0.5, row + 0.48, LETTERS[number], ha="center", va="center", fontsize=7, color=color)
    if all(axis.own is not None for axis in axes):
        corner = (axes[0].own or 0, (axes[1].own or 0) if len(axes) > 1 else 0)
        panel.add_patch(Rectangle(corner, 1, 1, fill=False, edgecolor="black", linewidth=1.6, clip_on=False, zorder=3))
    panel.grid(False)
    panel.set_title(f"{'motion' if of == 'run' else 'gradient'}: {mapped.map.title}", loc="left", fontsize=9)
    _ticks(panel, axes, labelled)


def _ticks(panel: Axes, axes: Sequence[Axis], labelled: bool) -> None:
    first, *second = axes
    panel.set_xticks(np.arange(len(first.values)) + 0.5, [short(first, k) for k in range(len(first.values))], fontsize=7)
    unit = f" in {first.unit}" if first.unit else ""
    panel.set_xlabel(f"{first.name}{', times that of the scene' if first.factor else unit}", fontsize=8)
    panel.tick_params(length=0)
    if second and labelled:
        panel.set_yticks(np.arange(len(second[0].values)) + 0.5, [short(second[0], k) for k in range(len(second[0].values))])
        panel.tick_params(axis="y", labelsize=7)
        panel.set_ylabel(second[0].name, fontsize=8)
    else:
        panel.set_yticks([])


def short(axis: Axis, index: int) -> str:
    """A value as short as possible: 1e-8 instead of 1e-08, 5e-4 instead of 0.0005."""
    value, text = axis.values[index], axis.label(index)
    if isinstance(value, str) or value == 0:
        return text
    digits, power = f"{value:.2e}".split("e")
    return min(text, f"{digits.rstrip('0').rstrip('.')}e{int(power)}", key=len).replace("-", MINUS)


def _legend(study: StabilityResult, sides: Sequence[Of]) -> list[Patch]:
    present = {v.name for each in study.maps for of in sides for v in verdicts(each, of).values()}
    patches = [
        Patch(facecolor=color, edgecolor="0.6", label=f"{letter}  {name}" if letter else name)
        for name, color, letter in zip(CLASSES, CLASS_COLORS, LETTERS, strict=True)
        if name in present
    ]
    return [*patches, Patch(facecolor="none", edgecolor="black", linewidth=1.6, label="as it stands")]
