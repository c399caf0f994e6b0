"""A certificate as a picture: matching digits of every gradient, and the V of the central differences."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from toolkit.render.sheet import sheet, style
from toolkit.report.drawing import Drawing
from toolkit.sensitivity.certificate.certificate import Certificate, digits

MOST_BARS = 40
"""Gradients that are drawn one by one; of more, those on which the methods agree least."""


def certificate_drawing(found: Certificate) -> Drawing:
    """Bars of agreeing digits above, the largest relative difference of central differences over their step below."""
    pairs = [(f, x) for f, slopes in found.exact.gradients.items() for x in slopes]
    agreement = {method: np.array([digits(each[f][x]) for f, x in pairs]) for method, each in found.differences.items()}
    least = np.min(list(agreement.values()), axis=0)
    shown = np.sort(np.argsort(least, kind="stable")[:MOST_BARS])
    rows = 0.25 * len(shown) + 0.7
    with sheet(rows + 2.9, 2, height_ratios=[rows, 2.6]) as (figure, axes):
        _bars(
            axes[0, 0], [f"d {pairs[k][0]} / d {pairs[k][1]}" for k in shown], {m: each[shown] for m, each in agreement.items()}
        )
        _curve(axes[1, 0], found)
    caption = (
        "Above: decimal digits on which direct differentiation and the other exact methods agree. Below: largest relative difference of "
        "central differences to it; their error falls with the step's square until round-off takes over."
    )
    return Drawing("certificate", "Agreement of independent methods", caption, figure)


def _bars(panel: Axes, names: list[str], agreement: dict[str, np.ndarray]) -> None:
    height = 0.8 / len(agreement)
    for number, (method, values) in enumerate(agreement.items()):
        panel.barh(np.arange(len(names)) + number * height, values, height, color=style(number)["color"], label=method)
    panel.set_yticks(np.arange(len(names)) + 0.4 - height / 2, names)
    panel.invert_yaxis()
    panel.set_xlim(0, 16)
    panel.set_xlabel("agreeing digits")
    panel.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=len(agreement))


def _curve(panel: Axes, found: Certificate) -> None:
    curve = [(step, value) for step, value in found.curve if value > 0]
    if curve:
        steps, values = np.array(curve).T
        panel.loglog(steps, values, marker="o", **style(0))
    panel.set_xlabel("relative step of central differences")
    panel.set_ylabel("relative difference")
