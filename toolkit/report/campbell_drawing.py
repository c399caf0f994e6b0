"""Campbell's diagram: frequencies over the speed of the spin, with the lines on which the spin excites them."""

from __future__ import annotations

import numpy as np

from toolkit.analyses.modes import Campbell
from toolkit.render.sheet import COLORS, sheet
from toolkit.report.drawing import Drawing

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
