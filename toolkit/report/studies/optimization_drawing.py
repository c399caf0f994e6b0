"""An optimisation as a picture: the objective and the constraints of every design, in the order in which they were solved."""

from __future__ import annotations

import numpy as np

from toolkit.render.sheet import sheet, style
from toolkit.report.drawing import Drawing
from toolkit.studies.engine.outcome import DesignOutcome
from toolkit.studies.optimization.optimum import Optimum
from toolkit.studies.optimization.prices import objective_of
from toolkit.studies.optimization.search.search_result import SearchResult

WIDE = 30.0
"""Largest objective over the least from where on the axis is logarithmic."""
LEAST = 1e-9
"""Violations below, and none, are drawn here."""


def history(found: Optimum) -> Drawing:
    """Drawing with a panel for the objective of all searches, and one for constraint violations if there are any."""
    name, unit = objective_of(found.search.program)
    constrained = any(_violation(search, each) > LEAST for search in found.searches for each in _designs(found, search))
    with sheet(2.7 * (1 + constrained) + 0.4, 1 + constrained, sharex=True) as (figure, axes):
        for k, search in enumerate(found.searches):
            _search(axes[:, 0], found, search, k, f"start {search.lane // 2 + 1}")
        if _ranges_widely(found):
            axes[0, 0].set_yscale("log")
        axes[0, 0].set_ylabel(f"{name} in {unit}".replace("^2", "\N{SUPERSCRIPT TWO}") if unit else name)
        axes[-1, 0].set_xlabel("designs of the search")
        if constrained:
            axes[1, 0].set_ylabel("largest violation,\nin parts of the limit")
            axes[1, 0].set_yscale("log")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    caption = "Objective of every design of the searches; crosses are designs that could not be solved."
    if constrained:
        caption += f" Below, the largest violation of a limit; {LEAST:g} stands for less and for none."
    return Drawing("history", "Designs of the optimisation", caption, figure)


def _search(panels: np.ndarray, found: Optimum, search: SearchResult, number: int, label: str) -> None:
    """Draw the curves of one search, with crosses at the foot of the first panel for what failed."""
    mine, look = _designs(found, search), style(number)
    good = [k for k, each in enumerate(mine) if not each.failed]
    objectives = [float(search.program.objective(mine[k].values)[0]) for k in good]
    panels[0].plot(good, objectives, marker=".", label=label, **look)
    lost = [k for k, each in enumerate(mine) if each.failed]
    panels[0].plot(lost, [0.02] * len(lost), "x", color=look["color"], transform=panels[0].get_xaxis_transform())
    if len(panels) > 1:
        panels[1].plot(good, [_violation(search, mine[k]) for k in good], marker=".", **look)


def _ranges_widely(found: Optimum) -> bool:
    """Whether objectives of all designs are positive, and differ by so much that a linear axis shows nothing of the end."""
    values = [float(found.search.program.objective(each.values)[0]) for each in found.solved if not each.failed]
    return min(values) > 0 and max(values) > WIDE * min(values)


def _designs(found: Optimum, search: SearchResult) -> list[DesignOutcome]:
    return [each for each in found.solved if each.lane == search.lane]


def _violation(search: SearchResult, design: DesignOutcome) -> float:
    """Largest constraint violation of a design; LEAST where the design failed or nothing is limited."""
    if design.failed or not search.program.rows:
        return LEAST
    return max(LEAST, float(np.max(-search.program.values(design).c)))
