"""Values and gradients of a run as tables of words: for a terminal, for a notebook, for `print`."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING, NamedTuple

from toolkit.scene.scene import Scene
from toolkit.scene_file.gradient_units import variable_unit

if TYPE_CHECKING:
    from toolkit.sensitivity.run import Run

MOST_COLUMNS = 8
"""More design variables than this stand one below the other."""


class ShortTable(NamedTuple):
    """Table of words: names of the columns, and rows; the first column names the rows."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def text(self) -> str:
        """Table as lines of plain text: words to the left, numbers to the right."""
        widths = [max(map(len, column)) for column in zip(self.columns, *self.rows, strict=True)]
        return "\n".join(_line(row, widths) for row in (self.columns, *self.rows))

    def html(self) -> str:
        """Table in HTML."""
        head = "".join(f"<th>{escape(name)}</th>" for name in self.columns)
        body = "".join("<tr>" + "".join(f"<td>{escape(word)}</td>" for word in row) + "</tr>" for row in self.rows)
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    first, *others = (
        word.ljust(width) if k == 0 else word.rjust(width) for k, (word, width) in enumerate(zip(row, widths, strict=True))
    )
    return "  ".join([first, *others]).rstrip()


def table_of_values(run: Run) -> ShortTable:
    """Table with value and unit of every response."""
    rows = tuple((name, f"{value:.6g}", run.units[name]) for name, value in run.values.items())
    return ShortTable(("response", "value", "unit"), rows)


def table_of_gradients(run: Run) -> ShortTable | None:
    """Table with derivatives of all responses by all variables; None if there are none."""
    variables = list(next(iter(run.gradients.values()), {}))
    if not variables:
        return None
    of = [_in_unit(name, run.units[name]) for name in run.gradients]
    by = _in_their_units(run.solution.system.scene, variables)
    if len(variables) > MOST_COLUMNS:
        cells = [[f"{slopes[name]:.6g}" for slopes in run.gradients.values()] for name in variables]
        return ShortTable(("gradient by", *of), tuple((label, *row) for label, row in zip(by, cells, strict=True)))
    cells = [[f"{slope:.6g}" for slope in slopes.values()] for slopes in run.gradients.values()]
    return ShortTable(("gradient by", *by), tuple((label, *row) for label, row in zip(of, cells, strict=True)))


def _in_unit(name: str, unit: str) -> str:
    return f"{name}, {unit}" if unit else name


def _in_their_units(scene: Scene, names: Sequence[str]) -> list[str]:
    """Design variables with their units: a gradient is in that of its response over that of its variable."""
    return [_in_unit(name, variable_unit(scene, scene.paths_of(name)[0])) for name in names]
