"""Speed against accuracy as a picture: every setting, the staircase of the best, the budget, and what is recommended."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.axes import Axes

from toolkit.report.sheet import COLORS, Drawing, sheet
from toolkit.studies.judged import Judged
from toolkit.studies.pareto import pareto
from toolkit.studies.tradeoff import Tradeoff

LEAST = 1e-15
"""Errors below are drawn here."""
MARKERS = "osD^vP<>"
MOST_SERIES = 8
"""Lines with names; of more, all are grey but the best."""


def work_precision(found: Tradeoff) -> Drawing:
    """One panel for the responses, one for their gradients if there are any: largest error over the median time."""
    kinds = [False, True] if any(quantity.derived for quantity in found.plan.budget) else [False]
    with sheet(0.7 + 3.1 * len(kinds) + 0.18 * min(_count(found), MOST_SERIES), len(kinds)) as (figure, axes):
        for panel, derived in zip(axes[:, 0], kinds, strict=True):
            _panel(panel, found, derived)
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=1 if _count(found) > 4 else 2)
    caption = "Largest relative error of any response, or gradient, over the median time of a run; the line joins the best."
    return Drawing("tradeoff", "Speed against accuracy", caption, figure)


def _count(found: Tradeoff) -> int:
    return len(_series(found))


def _series(found: Tradeoff) -> dict[str, list[Judged]]:
    """Settings that differ in their step alone, by what they have in common."""
    series: dict[str, list[Judged]] = {}
    for each in found.settings:
        if not each.record.failure:
            rest = [f"{axis} {label}" for axis, label in each.setting.labels.items() if axis != "step"]
            series.setdefault(", ".join(rest) or "steps", []).append(each)
    return series


def _panel(panel: Axes, found: Tradeoff, derived: bool) -> None:
    series = _series(found)
    for number, (name, members) in enumerate(series.items()):
        points = sorted((_point(each, derived) for each in members), reverse=True)
        many = len(series) > MOST_SERIES
        color = "0.7" if many else COLORS[number % len(COLORS)]
        label = ("other settings" if number == 0 else None) if many else name
        panel.plot(
            *zip(*points, strict=True), MARKERS[number % len(MARKERS)], color=color, markersize=4.5, label=label, alpha=0.9
        )
    everything = [each for members in series.values() for each in members]
    _staircase(panel, [_point(each, derived) for each in everything])
    _limits(panel, found, derived)
    if found.recommended:
        panel.plot(*_point(found.recommended, derived), "*", color="black", markersize=14, zorder=4, label="recommended")
    panel.set(xscale="log", yscale="log", xlabel="time with gradients in ms" if derived else "time in ms")
    panel.set_ylabel("largest error of gradients" if derived else "largest error of responses")


def _point(each: Judged, derived: bool) -> tuple[float, float]:
    """Time in ms and largest error."""
    error = each.largest(derived)
    return 1e3 * each.record.seconds[derived], max(error, LEAST) if math.isfinite(error) else math.nan


def _staircase(panel: Axes, points: Sequence[tuple[float, float]]) -> None:
    best = [points[k] for k in pareto(points)]
    if best:
        panel.step(*zip(*best, strict=True), where="post", color="black", linewidth=1, label="best for their time", zorder=1)


def _limits(panel: Axes, found: Tradeoff, derived: bool) -> None:
    """The strictest budget, and what the reference cannot tell."""
    limits = [limit for quantity, limit in found.plan.budget.items() if quantity.derived == derived]
    if limits:
        word = "budget" if len(set(limits)) == 1 else "strictest budget"
        panel.axhline(min(limits), color=COLORS[1], linestyle="--", linewidth=1, label=word if not derived else None)
    unsure = (
        max(found.reference.error(quantity) for quantity in found.plan.budget if quantity.derived == derived) if limits else 0.0
    )
    if unsure > LEAST:
        low = panel.get_ylim()[0]
        panel.axhspan(
            min(low, unsure / 10), unsure, color="0.9", zorder=0, label="uncertainty of the reference" if not derived else None
        )
