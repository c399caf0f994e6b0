"""Sheets that figures are drawn on: narrow enough to be read on a telephone, saved as PNG and SVG."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from toolkit.foundation.files.replaced_file import write_whole
from toolkit.render.settings import drawing_settings

WIDTH = 5.6
"""Inches. On a screen of 400 pixels a letter of 10 points is still 9 pixels high."""
SIGNED, UNSIGNED = "coolwarm", "viridis"
"""Colour maps that colour-blind people can read: from minus to plus the same value, and from zero up."""
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Okabe and Ito's colours, told apart by all kinds of colour vision."""
STYLES = ("-", "--", "-.", ":")
_SETTINGS: Any = {
    "font.size": 10, "axes.titlesize": 10, "legend.fontsize": 9, "legend.frameon": False, "axes.grid": True, "grid.alpha": 0.3,
    "svg.hashsalt": "ffrf-toolkit", "lines.linewidth": 1.6,
}  # fmt: skip


@dataclass(frozen=True)
class Drawing:
    """A figure with its file name, its title and the sentence below it."""

    name: str
    title: str
    caption: str
    figure: Figure

    def save(self, folder: Path) -> list[Path]:
        """Write PNG and SVG, each in one stroke."""
        files = [folder / f"{self.name}.{kind}" for kind in ("png", "svg")]
        for path in files:
            self.save_as(path)
        return files

    def save_as(self, path: Path) -> None:
        """Write one file, PNG or SVG by its name's end."""
        file = BytesIO()
        with drawing_settings(_SETTINGS):
            # without a date the same numbers give the same file
            metadata = {"Date": None} if path.suffix == ".svg" else {}
            self.figure.savefig(file, format=path.suffix[1:], dpi=180, metadata=metadata)
        write_whole(path, file.getvalue())


@contextmanager
def sheet(height: float, rows: int = 1, columns: int = 1, **options: Any) -> Iterator[tuple[Figure, np.ndarray]]:
    """A figure of a height in inches, and its axes (rows, columns); options as for `Figure.subplots`."""
    with drawing_settings(_SETTINGS):
        figure = Figure(figsize=(WIDTH, height), layout="constrained")
        FigureCanvasAgg(figure)
        yield figure, figure.subplots(rows, columns, squeeze=False, **options)


def style(number: int) -> dict[str, Any]:
    """Colour and dashes of the n-th curve; dashes tell curves apart where colours cannot."""
    return {"color": COLORS[number % len(COLORS)], "linestyle": STYLES[number % len(STYLES)]}


def symmetric(values: Sequence[np.ndarray] | np.ndarray) -> Normalize:
    """Colours from minus to plus the largest finite value."""
    flat = np.concatenate([np.ravel(each) for each in values]) if len(values) else np.zeros(1)
    limit = float(np.abs(flat[np.isfinite(flat)]).max(initial=0.0)) or 1.0
    return Normalize(-limit, limit)
