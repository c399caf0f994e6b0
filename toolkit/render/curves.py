"""Curves over the times of a solution: panels below each other, what coincides drawn once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import fill

import numpy as np
from matplotlib.figure import Figure

from toolkit.foundation.units import unit
from toolkit.render.moment import Moment
from toolkit.render.readable_units import readable
from toolkit.render.sheet import WIDE, sheet, style
from toolkit.system.solution import Solution

Panels = list[tuple[str, str, dict[str, np.ndarray]]]
"""Panels of a figure: title, physical quantity, and values over time by name."""
SEEN = 1e-9
"""A rotation in rad, or a way in parts of the model size, below which curves are zero: round-off."""
EVEN = 1e-6
"""A change that no curve shows, in parts of the values."""
HIDDEN = 1e-3
"""Part of the largest value of a panel that the width of a line hides."""
_ROWS, _LETTERS = 9, 28
"""Names below each other beside a panel, and letters of one in a line."""


def draw_panels(solution: Solution, panels: Panels) -> Figure:
    """Draw a panel per quantity, each in a unit in which its numbers are short."""
    scene, units = solution.system.scene, solution.system.scene.units
    seen = {"angle": SEEN, "length": SEEN * scene.size}
    with sheet(0.8 + 2.6 * len(panels), len(panels), width=WIDE, sharex=True) as (figure, axes):
        for panel, (what, quantity, curves) in zip(axes[:, 0], panels, strict=True):
            factor, label = readable(max(float(np.abs(values).max()) for values in curves.values()), unit(units, quantity))
            curves = told(curves)
            for number, (name, exact) in enumerate(curves.items()):
                values = np.where(np.abs(exact) > seen.get(quantity, 0.0), exact, 0.0)
                panel.plot(
                    solution.times, factor * values, marker="." if len(values) < 100 else None, label=name, **style(number)
                )
            panel.set_ylabel(f"{what} in {label}")
            panel.set_ylim(bottom=0 if min(np.min(values) for values in curves.values()) >= 0 else None)
            low, high = panel.dataLim.intervaly
            size = max(abs(low), abs(high))
            if size and high - low <= EVEN * size:  # digits that nobody asked for would be the scale
                panel.set_ylim(low - 0.1 * abs(low), high + 0.1 * abs(high))
            columns = -(-len(curves) // _ROWS)
            labels = [fill(name, _LETTERS, break_long_words=False, break_on_hyphens=False) for name in curves]
            words = panel.legend(labels, loc="upper left", bbox_to_anchor=(1.0, 1.0), ncols=columns).get_texts()
            for word in words:
                word.set_parse_math(False)  # a dollar in a name starts no formula
        axes[-1, 0].set_xlabel(f"time in {unit(units, 'time')}")
        axes[-1, 0].set_xlim(solution.times[0], solution.times[-1])
        figure.align_ylabels()
    return figure


def motion_panels(start: Mapping[str, np.ndarray], moments: Sequence[Moment]) -> Panels:
    """Distance of every named point that moves from where it is undeformed, `start`."""
    places = [moment.named_points() for moment in moments]
    curves = {point: np.array([np.linalg.norm(place[point] - start[point]) for place in places]) for point in sorted(start)}
    seen = SEEN * moments[0].solution.system.scene.size
    moved = {point: values for point, values in curves.items() if values.max() > seen}
    return [("motion of points", "length", merged(moved))] if moved else []


def told(curves: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Curves without those that are zero throughout, to a thousandth of the largest value; all curves if no other is left.

    A line that is drawn hides such a curve.
    """
    size = {name: float(np.abs(values).max(initial=0)) for name, values in curves.items()}
    return {name: values for name, values in curves.items() if size[name] > HIDDEN * max(size.values())} or curves


def merged(curves: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Curves drawn once each: those that coincide, to a thousandth of the largest value, which a line hides, share a name."""
    near = HIDDEN * max(np.abs(values).max() for values in curves.values())
    groups: list[list[str]] = []
    for name, values in curves.items():
        same = [group for group in groups if np.allclose(curves[group[0]], values, rtol=0, atol=near)]
        if same:
            same[0].append(name)
        else:
            groups.append([name])
    return {", ".join(group): curves[group[0]] for group in groups}
