"""Speed against accuracy as a picture: every setting, the staircase of the best, the budget, and what is recommended."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.axes import Axes

from toolkit.render.sheet import COLORS, sheet
from toolkit.report.drawing import Drawing
from toolkit.studies.tradeoff.setting import Setting
from toolkit.studies.tradeoff.tradeoff import JudgedSetting, Tradeoff, pareto

LEAST = 1e-15
"""Errors below are drawn here."""
MARKERS = "osD^vP<>"
MOST_SERIES = 8
"""Series with colours and names; of more, those with the best settings have them, and all others are grey."""
Point = tuple[float, float]


def work_precision(found: Tradeoff) -> Drawing:
    """Drawing of largest error over median time: a panel for responses, and one for gradients if these have budgets.

    Where budgets differ, errors are drawn in units of them. At least one setting has to have worked.
    """
    kinds = [derived for derived in (False, True) if _budgets(found, derived)]
    series = _series(found)
    named = _named(found, series)
    columns = 1 if max(map(len, named)) > 25 else 2
    entries = (len(named) + 5) / columns
    with sheet(3.1 * len(kinds) + 0.22 * entries, len(kinds)) as (figure, axes):
        for panel, derived in zip(axes[:, 0], kinds, strict=True):
            _panel(panel, found, series, named, derived)
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=columns)
    caption = "Largest relative error of any response, or gradient, over the median time of a run; the line joins the best."
    return Drawing("tradeoff", "Speed against accuracy", caption, figure)


def _series(found: Tradeoff) -> dict[str, list[JudgedSetting]]:
    """Settings that differ in their step, or local error, alone, by what they have in common, in the order of the axes."""
    places = {id(setting): k for k, setting in enumerate(found.plan.settings)}
    series: dict[str, list[JudgedSetting]] = {}
    for each in sorted(found.settings, key=lambda each: places[id(each.setting)]):
        if not each.outcome.failed:
            series.setdefault(_shared_words(each.setting), []).append(each)
    return series


def _shared_words(setting: Setting) -> str:
    words = {"false": "", "true": "{axis}"}
    parts = [
        words.get(label, "{axis} {label}").format(axis=axis, label=label)
        for axis, label in setting.labels.items()
        if axis not in ("step", "local_error")
    ]
    adaptive = ["adaptive steps"] if setting.solver.get("local_error") else []
    return ", ".join([part for part in parts if part] + adaptive) or "equal steps"


def _named(found: Tradeoff, series: dict[str, list[JudgedSetting]]) -> list[str]:
    """Series with colours: all, or of too many those with members of the Pareto set, nearest to the recommendation first."""
    if len(series) <= MOST_SERIES:
        return list(series)
    best = {id(each): number for number, each in enumerate(sorted(found.pareto, key=lambda each: each is not found.recommended))}
    ranks = {name: min((best[id(each)] for each in members if id(each) in best), default=-1) for name, members in series.items()}
    return sorted([name for name, rank in ranks.items() if rank >= 0], key=lambda name: ranks[name])[:MOST_SERIES]


def _panel(panel: Axes, found: Tradeoff, series: dict[str, list[JudgedSetting]], named: list[str], derived: bool) -> None:
    panel.set(xscale="log", yscale="log", xlabel="time with gradients in ms" if derived else "time in ms")
    what = "largest error of gradients" if derived else "largest error of responses"
    panel.set_ylabel(what if _common(found, derived) else f"{what}, in budgets")
    points = [_point(found, each, derived) for members in series.values() for each in members]
    _points(panel, found, series, named, derived)
    best = [points[k] for k in pareto(points)]
    if best:
        panel.step(*zip(*best, strict=True), where="post", color="black", linewidth=1, label="best for their time", zorder=1)
    _window(panel, points, _common(found, derived) or 1.0)
    _limits(panel, found, derived)
    if found.recommended:
        panel.plot(*_point(found, found.recommended, derived), "*", color="black", markersize=14, zorder=4, label="recommended")


def _points(panel: Axes, found: Tradeoff, series: dict[str, list[JudgedSetting]], named: list[str], derived: bool) -> None:
    """Draw settings as points; a dotted line joins those that differ in their steps alone, from coarsest to finest."""
    rest = "other settings"
    for name in sorted(series, key=lambda name: name in named):  # colours above grey
        look = {"color": "0.75", "marker": "."}
        if name in named:
            number = named.index(name)
            look = {"color": COLORS[number % len(COLORS)], "marker": MARKERS[number % len(MARKERS)]}
        points = [_point(found, each, derived) for each in sorted(series[name], key=lambda each: each.outcome.steps)]
        label = name if name in named else rest
        panel.plot(*zip(*points, strict=True), linestyle=":", linewidth=0.8, markersize=4.5, label=label, **look)  # type: ignore[arg-type]
        rest = rest if name in named else "_"  # named once


def _point(found: Tradeoff, each: JudgedSetting, derived: bool) -> Point:
    """Time in ms and largest error, or part of its budget."""
    error = each.largest(derived)
    if not _common(found, derived):
        budget = found.plan.budget
        error = max(each.errors[quantity] / budget[quantity] for quantity in budget if quantity.derived == derived)
    return 1e3 * each.outcome.medians[derived], max(error, LEAST) if math.isfinite(error) else math.nan


def _budgets(found: Tradeoff, derived: bool) -> list[float]:
    return [limit for quantity, limit in found.plan.budget.items() if quantity.derived == derived]


def _common(found: Tradeoff, derived: bool) -> float | None:
    """Budget of all responses, or of all gradients, if it is the same."""
    limits = set(_budgets(found, derived))
    return limits.pop() if len(limits) == 1 else None


def _limits(panel: Axes, found: Tradeoff, derived: bool) -> None:
    """Draw the budget, and the uncertainty of the reference if that reaches into the window."""
    common, budget = _common(found, derived), found.plan.budget
    panel.axhline(common or 1.0, color=COLORS[1], linestyle="--", linewidth=1, label="budget")
    of = [quantity for quantity in budget if quantity.derived == derived]
    unsure = max(found.reference.error(quantity) / (1 if common else budget[quantity]) for quantity in of)
    if unsure > panel.get_ylim()[0]:
        panel.axhspan(LEAST, unsure, color="0.9", zorder=0, label="uncertainty of the reference")


def _window(panel: Axes, points: Sequence[Point], budget: float) -> None:
    """Set limits with room for the points and the budget, and ticks of times that are read as numbers."""
    times, errors = zip(*points, strict=True)
    seen = [error for error in errors if math.isfinite(error)] + [budget]
    panel.set_ylim(min(seen) / 4, 4 * max(seen))
    low, high = min(times) / 1.2, max(times) * 1.2
    panel.set_xlim(low, high)
    digits = (1, 1.5, 2, 3, 4, 5, 7) if high < 10 * low else (1, 2, 5) if high < 300 * low else (1,)
    ticks = [digit * 10.0**power for power in range(-4, 8) for digit in digits if low <= digit * 10.0**power <= high]
    panel.minorticks_off()
    panel.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
