"""Pictures of studies of many designs: sweeps, uncertain responses, and the designs of an optimisation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps

from toolkit.render.sheet import COLORS, UNSIGNED, WIDE, sheet, style
from toolkit.report.drawing import Drawing
from toolkit.studies.optimization.explored import SearchResult
from toolkit.studies.optimization.optimum import Optimum
from toolkit.studies.optimization.program import objective_of
from toolkit.studies.orthonormal_basis import scrambled
from toolkit.studies.store import DesignOutcome
from toolkit.studies.sweep import Swept
from toolkit.studies.uncertain_result import UncertainResult, limits_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TANGENT = 0.25
"""Length of a tangent in parts of the distance of two designs."""
MOST_LINES = 500
"""Lines of parallel coordinates beyond which the paper would be black: every so many designs are drawn."""
SAMPLES, BINS = 2**14, 60
"""Points of the polynomials that are drawn, and bars of a histogram."""
RANGE = 30.0
"""Largest objective over the least from where on the axis is logarithmic."""
MET = 1e-9
"""Violations below, and none, are drawn here."""


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
            look: dict[str, Any] = (
                {"color": "0.4", "linestyle": ":"} if failed else {"color": colormaps[UNSIGNED](row[len(moved)])}
            )
            panel.plot(range(len(names)), row, linewidth=0.8, alpha=0.7, **look)
        ticks = [f"{name}\n{a:.4g} to {b:.4g}" for name, a, b in zip(names, low, high, strict=True)]
        panel.set_xticks(range(len(names)), ticks, rotation=60, ha="right", parse_math=False)
        panel.set_yticks([0, 1], ["least", "largest"])
        panel.set_xlim(0, len(names) - 1)
    caption = f"Every line is a design, coloured by {labels[0]}; dotted ones could not be solved." + (
        f" One of {step} designs is drawn." if step > 1 else ""
    )
    return Drawing("sweep", "Sweep", caption, figure)


def uncertainty_drawing(found: UncertainResult) -> Drawing:
    """Drawing with a row per response: its density with its limits, and the shares of its variance."""
    labels, joint = list(found.responses), found.study.joint
    germs = joint.germs_of(scrambled(SAMPLES, len(joint.marginals), found.study.options.seed))
    with sheet(0.6 + 2.3 * len(labels), len(labels), 2, width=WIDE) as (figure, axes):
        for (left, right), label in zip(axes, labels, strict=True):
            _density(left, found, label, found.values(label, germs))
            _shares(right, found, label)
        axes[-1, 1].set_xlabel("share of the variance")
        known = next((k for k, label in enumerate(labels) if np.isfinite(found.responses[label].mean)), 0)
        figure.legend(*axes[known, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    caption = (
        "Left: densities of the responses with mean, mean plus and minus sigma, and limits. Right: shares of the variance that come from a "
        "number alone (full) and from it together with others (light)."
    )
    return Drawing("uncertainty", "Uncertain responses", caption, figure)


def _density(panel: Axes, found: UncertainResult, label: str, values: np.ndarray) -> None:
    each = found.responses[label]
    if np.isnan(each.mean):
        panel.text(0.5, 0.5, f"{label} is cut off", ha="center", transform=panel.transAxes, parse_math=False)
        panel.set_yticks([])
        return
    panel.hist(values, BINS, density=True, color=COLORS[5], label="polynomials")
    if each.sampled is not None:
        place = list(found.responses).index(label)
        cases = len(found.study.problem.cases)
        random = [e.values[place % cases, place // cases] for e in found.sampled if not e.failed]
        bins = max(5, min(BINS, int(len(random) ** 0.5)))
        panel.hist(random, bins, density=True, histtype="step", color=COLORS[6], label="random designs")
    for number, line in ((each.mean, "-"), (each.mean - each.sigma, ":"), (each.mean + each.sigma, ":")):
        panel.axvline(number, color=COLORS[0], linestyle=line, label="mean" if line == "-" else None)
    name = found.study.problem.responses[list(found.responses).index(label) // len(found.study.problem.cases)]
    for limit, _ in limits_of(found.study.problem.study.constraints.get(name)).values():
        panel.axvline(limit, color=COLORS[1], linestyle="--", label="limit")
    panel.set_xlabel(f"{label}, {each.unit}" if each.unit else label, parse_math=False)
    panel.set_yticks([])


def _shares(panel: Axes, found: UncertainResult, label: str) -> None:
    each, names = found.responses[label], found.study.problem.variables
    if each.alone is None or each.together is None:
        panel.text(
            0.5, 0.5, "no shares" if np.isnan(each.mean) else "numbers go together", ha="center", transform=panel.transAxes
        )
        return
    places = np.arange(len(names))
    panel.barh(places, [each.together[name] for name in names], color=COLORS[5])
    panel.barh(places, [each.alone[name] for name in names], color=COLORS[0])
    panel.set_yticks(places, names, parse_math=False)
    panel.set_xlim(0, 1)
    panel.invert_yaxis()


def optimization_drawing(found: Optimum) -> Drawing:
    """Drawing with a panel for the objective of all searches, and one for constraint violations if there are any."""
    name, unit = objective_of(found.search.program)
    constrained = any(_violation(search, each) > MET for search in found.searches for each in _designs(found, search))
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
        caption += f" Below, the largest violation of a limit; {MET:g} stands for less and for none."
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
    return min(values) > 0 and max(values) > RANGE * min(values)


def _designs(found: Optimum, search: SearchResult) -> list[DesignOutcome]:
    return [each for each in found.solved if each.lane == search.lane]


def _violation(search: SearchResult, design: DesignOutcome) -> float:
    """Largest constraint violation of a design; MET where the design failed or nothing is limited."""
    if design.failed or not search.program.rows:
        return MET
    return max(MET, float(np.max(-search.program.values(design).c)))
