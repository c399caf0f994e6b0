"""Uncertain responses as a picture: how they are distributed, and which numbers their spread comes from."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.render.sheet import COLORS, WIDE, sheet
from toolkit.report.drawing import Drawing
from toolkit.studies.distributions.sobol_points import scrambled
from toolkit.studies.uncertainty.spread import limits_of
from toolkit.studies.uncertainty.uncertain_result import UncertainResult

SAMPLES, BINS = 2**14, 60
"""Points of the polynomials that are drawn, and bars of a histogram."""


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


def _density(panel: Any, found: UncertainResult, label: str, values: np.ndarray) -> None:
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
    for number, style in ((each.mean, "-"), (each.mean - each.sigma, ":"), (each.mean + each.sigma, ":")):
        panel.axvline(number, color=COLORS[0], linestyle=style, label="mean" if style == "-" else None)
    name = found.study.problem.responses[list(found.responses).index(label) // len(found.study.problem.cases)]
    for limit, _ in limits_of(found.study.problem.study.constraints.get(name)).values():
        panel.axvline(limit, color=COLORS[1], linestyle="--", label="limit")
    panel.set_xlabel(f"{label}, {each.unit}" if each.unit else label, parse_math=False)
    panel.set_yticks([])


def _shares(panel: Any, found: UncertainResult, label: str) -> None:
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
