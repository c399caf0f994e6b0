"""A sweep as a picture: curves over one variable, maps over two, parallel coordinates over more."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import colormaps

from toolkit.render.sheet import COLORS, UNSIGNED, sheet
from toolkit.report.drawing import Drawing
from toolkit.studies.sweep.swept import Swept

TANGENT = 0.25
"""Length of a tangent in parts of the distance of two designs."""
MOST_LINES = 500
"""Lines of parallel coordinates beyond which the paper would be black: every so many designs are drawn."""


def sweep_drawing(found: Swept) -> Drawing:
    """Drawing of a sweep in the form that suits the number of its variables."""
    moved = [k for k in range(found.designs.shape[1]) if np.ptp(found.designs[:, k]) > 0]
    if len(moved) <= 1:
        return _curves(found, moved[0] if moved else 0)
    return _maps(found, moved) if len(moved) == 2 else _parallel(found, moved)


def _label(name: str, unit: str) -> str:
    return f"{name}, {unit}" if unit else name


def _variable(found: Swept, k: int) -> str:
    name = found.problem.variables[k]
    return _label(name, found.problem.unit_of_variable(name))


def _curves(found: Swept, k: int) -> Drawing:
    """Draw a panel per response, with a tangent at every design and crosses at the foot for what failed."""
    order = np.argsort(found.designs[:, k], kind="stable")
    x = found.designs[order, k]
    half = TANGENT * (np.ptp(x) / max(len(x) - 1, 1))
    labels = list(found.responses)
    with sheet(0.6 + 2.2 * len(labels), len(labels), sharex=True) as (figure, axes):
        for panel, label in zip(axes[:, 0], labels, strict=True):
            y, slopes = found.values(label)[order], found.gradients(label)[order, k]
            panel.plot(x, y, ".-", color=COLORS[0])
            for a, b, slope in zip(x, y, slopes, strict=True):
                panel.plot([a - half, a + half], [b - half * slope, b + half * slope], color=COLORS[1], linewidth=1.0)
            lost = x[np.isnan(y)]
            panel.plot(lost, np.full(len(lost), 0.03), "x", color=COLORS[6], transform=panel.get_xaxis_transform())
            panel.set_ylabel(_label(label, found.units[label]), parse_math=False)
        axes[-1, 0].set_xlabel(_variable(found, k), parse_math=False)
    caption = "Responses over the variable with their derivatives; crosses are designs that could not be solved."
    return Drawing("sweep", "Sweep", caption, figure)


def _maps(found: Swept, moved: list[int]) -> Drawing:
    """Draw a panel per response: designs in the plane of the two variables, coloured by the response."""
    x, y = found.designs[:, moved].T
    lost = np.array([each.failed for each in found.solved])
    labels = list(found.responses)
    with sheet(0.6 + 3.0 * len(labels), len(labels), sharex=True) as (figure, axes):
        for panel, label in zip(axes[:, 0], labels, strict=True):
            points = panel.scatter(x[~lost], y[~lost], c=found.values(label)[~lost], cmap=UNSIGNED)
            panel.plot(x[lost], y[lost], "x", color=COLORS[6])
            figure.colorbar(points, ax=panel).set_label(_label(label, found.units[label]), parse_math=False)
            panel.set_ylabel(_variable(found, moved[1]), parse_math=False)
        axes[-1, 0].set_xlabel(_variable(found, moved[0]), parse_math=False)
    return Drawing("sweep", "Sweep", "Responses over the variables; crosses are designs that could not be solved.", figure)


def _parallel(found: Swept, moved: list[int]) -> Drawing:
    """Draw a line per design across variables and responses, each between its extremes, coloured by the first response."""
    labels = list(found.responses)
    table = np.column_stack([found.designs[:, moved], *(found.values(label) for label in labels)])
    low, high = np.nanmin(table, axis=0), np.nanmax(table, axis=0)
    places = (table - low) / np.where(high > low, high - low, 1.0)
    names = [*(_variable(found, k) for k in moved), *(_label(label, found.units[label]) for label in labels)]
    step = -(-len(table) // MOST_LINES)
    lost = np.array([each.failed for each in found.solved])
    width = max(5.6, 1.1 * len(names))
    with sheet(4.2, width=width) as (figure, axes):
        panel = axes[0, 0]
        for row, failed in zip(places[::step], lost[::step], strict=True):
            style: dict[str, Any] = (
                {"color": "0.4", "linestyle": ":"} if failed else {"color": colormaps[UNSIGNED](row[len(moved)])}
            )
            panel.plot(range(len(names)), row, linewidth=0.8, alpha=0.7, **style)
        ticks = [f"{name}\n{a:.4g} to {b:.4g}" for name, a, b in zip(names, low, high, strict=True)]
        panel.set_xticks(range(len(names)), ticks, rotation=60, ha="right", parse_math=False)
        panel.set_yticks([0, 1], ["least", "largest"])
        panel.set_xlim(0, len(names) - 1)
    caption = f"Every line is a design, coloured by {labels[0]}; dotted ones could not be solved." + (
        f" One of {step} designs is drawn." if step > 1 else ""
    )
    return Drawing("sweep", "Sweep", caption, figure)
