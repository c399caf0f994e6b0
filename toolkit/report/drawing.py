"""A figure of the report with its words, saved as PNG and SVG."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from toolkit.render.sheet import write_figure

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
