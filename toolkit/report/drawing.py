"""A figure of the report with its words, saved as PNG and SVG."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from toolkit.analyses.modes import Campbell
from toolkit.analyses.sensitivity.certificate.certificate import Certificate, digits
from toolkit.render.sheet import COLORS, sheet, style, write_figure

_DOTS = 180
"""Per inch."""


@dataclass(frozen=True)
class Drawing:
    """A figure with its file name, its title and the sentence below it."""

    name: str
    title: str
    caption: str
    figure: Figure

    def save(self, folder: Path) -> list[Path]:
        """Write PNG and SVG, each in one stroke; laid out once, by the first, so that both show the same."""
        files = [folder / f"{self.name}.{kind}" for kind in ("png", "svg")]
        for path in files:
            self.save_as(path)
            self.figure.set_layout_engine("none")
        return files

    def save_as(self, path: Path) -> None:
        """Write one file, PNG or SVG by its name's end."""
        write_figure(self.figure, path, _DOTS)


ORDERS = (1, 2, 3, 4)
"""Multiples of the speed."""


def campbell_drawing(found: Campbell, name: str) -> Drawing:
    """Drawing of Campbell's diagram as dots, because curves may cross; hollow ones where a motion grows."""
    with sheet(4.2) as (figure, axes):
        panel = axes[0, 0]
        top = 1.08 * float(np.nanmax(np.abs(found.frequencies), initial=0.0)) or 1.0
        far = 1.02 * float(found.speeds.max()) or 1.0
        for order in ORDERS:
            end = min(far, 2 * np.pi * top / order)
            panel.plot([0, end], [0, order * end / (2 * np.pi)], color="0.6", linewidth=0.8, linestyle="--")
            above = end < far  # outside of the axes, where no dot is
            panel.annotate(
                f"{order}x", (end, order * end / (2 * np.pi)), (0, 3) if above else (3, 0), textcoords="offset points",
                color="0.4", fontsize=8, ha="center" if above else "left", va="bottom" if above else "center",
            )  # fmt: skip
        for number, (values, damping) in enumerate(zip(found.frequencies.T, found.damping.T, strict=True)):
            color = COLORS[number % len(COLORS)]
            for grows in (False, True):
                chosen = ((values < 0) | (damping < 0)) == grows
                panel.plot(
                    found.speeds[chosen],
                    np.abs(values[chosen]),
                    "o",
                    markersize=4,
                    color=color,
                    markerfacecolor="white" if grows else color,
                )
        panel.set_xlim(0, far)
        panel.set_ylim(0, top)
        panel.set_xlabel("speed in rad/s")
        panel.set_ylabel("frequency in Hz")
    caption = "Frequencies in the frame that spins; dashed lines are multiples of the speed, hollow dots are motions that grow."
    return Drawing("campbell", f"Frequencies of {name} over its speed", caption, figure)


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
