"""Sheets that figures are drawn on: letters of one size on all of them, one file for the same numbers on every machine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context, rcdefaults, rcParams
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from toolkit.foundation.files.replaced_file import write_whole

NARROW, WIDE = 5.6, 10.0
"""Inches: a figure that is read on a telephone (of 400 pixels, where a letter of 10 points is still 9 pixels high), and a picture."""
_MOST = 6
"""Intervals along the lower edge of a narrow figure, whose numbers may be long."""
SIGNED, UNSIGNED = "coolwarm", "viridis"
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
    height: float, rows: int = 1, columns: int = 1, width: float = NARROW, **options: Any
) -> Iterator[tuple[Figure, np.ndarray]]:
    """A figure of a height and width in inches, and its axes (rows, columns); options as for `Figure.subplots`."""
    with _settings():
        figure = Sheet(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots(rows, columns, squeeze=False, **options)
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


def style(number: int) -> dict[str, Any]:
    """Colour and dashes of the n-th curve; dashes tell curves apart where colours cannot."""
    return {"color": COLORS[number % len(COLORS)], "linestyle": STYLES[number % len(STYLES)]}


def symmetric(values: Sequence[np.ndarray] | np.ndarray) -> Normalize:
    """Colours from minus to plus the largest finite value."""
    flat = np.concatenate([np.ravel(each) for each in values]) if len(values) else np.zeros(1)
    limit = float(np.abs(flat[np.isfinite(flat)]).max(initial=0.0)) or 1.0
    return Normalize(-limit, limit)
