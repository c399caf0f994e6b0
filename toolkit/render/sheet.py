"""Sheets that figures are drawn on: letters of one size on all of them, one file for the same numbers on every machine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from textwrap import fill
from typing import Any, Final, TypedDict

import numpy as np
from matplotlib import rc_context, rcdefaults, rcParams
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from toolkit.foundation.files.safe_files import write_whole
from toolkit.foundation.units import unit
from toolkit.render.moment import Moment
from toolkit.render.readable_units import readable
from toolkit.system.solution import Solution

NARROW, WIDE = 5.6, 10.0
"""Inches: a figure that is read on a telephone (of 400 pixels, where a letter of 10 points is still 9 pixels high), and a picture."""
_MOST = 6
"""Intervals along the lower edge of a narrow figure, whose numbers may be long."""
SIGNED: Final = "coolwarm"
UNSIGNED: Final = "viridis"
"""Colour maps that colour-blind people can read: from minus to plus the same value, and from zero up."""
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Okabe and Ito's colours, told apart by all kinds of colour vision."""
STYLES = ("-", "--", "-.", ":")
_SETTINGS: Any = {
    "font.size": 10, "axes.titlesize": 10, "legend.fontsize": 9, "legend.frameon": False, "axes.grid": True, "grid.alpha": 0.3,
    "svg.hashsalt": "ffrf-toolkit", "lines.linewidth": 1.6,
}  # fmt: skip
_UNDATED: dict[str, Any] = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
"""Format -> what a file leaves out, so that the same numbers give the same file."""


@contextmanager
def _settings() -> Iterator[None]:
    """Settings of matplotlib and of our own, never those of a `matplotlibrc` in the current folder, which can start LaTeX."""
    with rc_context():
        rcdefaults()
        rcParams.update(_SETTINGS)
        yield


class Sheet(Figure):
    """Figure that every notebook shows; matplotlib's own are shown where the notebook has enabled matplotlib before."""

    def _repr_png_(self) -> bytes:
        return written(self, "png", self.dpi)


@contextmanager
def sheet(
    height: float,
    rows: int = 1,
    columns: int = 1,
    width: float = NARROW,
    sharex: bool = False,
    width_ratios: Sequence[float] | None = None,
    height_ratios: Sequence[float] | None = None,
) -> Iterator[tuple[Figure, np.ndarray]]:
    """A figure of a height and width in inches, and its axes (rows, columns); ratios as for `Figure.subplots`."""
    with _settings():
        figure = Sheet(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots(
            rows, columns, squeeze=False, sharex=sharex, width_ratios=width_ratios, height_ratios=height_ratios
        )
        for each in axes.flat if width <= NARROW else ():
            each.locator_params(axis="x", nbins=_MOST)
        yield figure, axes


def settle(figure: Figure, fit: Callable[[], None] = lambda: None, like: Figure | None = None) -> None:
    """Lay a figure out for good, so that what is drawn from now on knows its scale; `fit` may adapt limits to the room there is.

    The axes stand where they do in a figure `like` it, if there is one.
    """
    before: list[Any] = []
    if like is not None:
        figure.set_layout_engine("none")
        for axes, known in zip(figure.axes, like.axes, strict=True):
            axes.set_position(known.get_position())
        fit()
        return
    for _ in range(3):  # a round may make numbers of ticks narrower or wider
        engine = figure.get_layout_engine()
        if engine is not None:
            engine.execute(figure)
        fit()
        now = [(*axes.get_position().bounds, *axes.get_xlim(), *axes.get_ylim()) for axes in figure.axes]
        if np.shape(now) == np.shape(before) and np.allclose(now, before, rtol=1e-9, atol=0):
            break
        before = now
    figure.set_layout_engine("none")


def write_figure(figure: Figure, path: Path, dots: float) -> None:
    """Write a figure in one stroke, as PNG, SVG or PDF by the name's end; pixels have that many dots per inch."""
    write_whole(path, written(figure, path.suffix[1:], dots))


def written(figure: Figure, kind: str, dots: float) -> bytes:
    """Content of a file with the figure, "png", "svg" or "pdf"."""
    file = BytesIO()
    with _settings():
        figure.savefig(file, format=kind, dpi=dots, metadata=_UNDATED[kind])
    return file.getvalue()


class LineStyle(TypedDict):
    """What tells a curve from others."""

    color: str
    linestyle: str


def style(number: int) -> LineStyle:
    """Colour and dashes of the n-th curve; dashes tell curves apart where colours cannot."""
    return {"color": COLORS[number % len(COLORS)], "linestyle": STYLES[number % len(STYLES)]}


def symmetric(values: Sequence[np.ndarray] | np.ndarray) -> Normalize:
    """Colours from minus to plus the largest finite value."""
    flat = np.concatenate([np.ravel(each) for each in values]) if len(values) else np.zeros(1)
    limit = float(np.abs(flat[np.isfinite(flat)]).max(initial=0.0)) or 1.0
    return Normalize(-limit, limit)


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
