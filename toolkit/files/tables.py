"""Results as tables: CSV files with names and units in the first line, and short tables of words for a terminal or a notebook."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from toolkit.files.gradient_units import variable_unit
from toolkit.files.results import BodyResults, Results
from toolkit.foundation.files.safe_files import own_set, refuse_foreign, safe_name, write_whole
from toolkit.scene.scene import Scene

if TYPE_CHECKING:
    from toolkit.analyses.sensitivity.run import Run


STATES = {"coordinates": "q", "velocities": "v", "accelerations": "a"}
BY_BODY = "stress_*.csv", "shape_error_*.csv"
"""Tables that other results may not have."""


def export_csv(results: Results, directory: str | Path) -> list[Path]:
    """Write all tables into a folder, which is made if it does not exist.

    Returns
    -------
    files : `responses.csv` with gradients; `coordinates.csv`, `velocities.csv`, `accelerations.csv`, `multipliers.csv`, a line per
        time; per flexible body `stress_<body>.csv`, `shape_error_<body>.csv`, and both again per variable

    Raises
    ------
    InputError
        There are files of these names that ffrf has not written.
    """
    directory = Path(directory)
    time = f"time in {results.unit('time')}"
    tables = {name: (results.coordinates, getattr(results, field)) for name, field in STATES.items()}
    tables["multipliers"] = (results.multiplier_names, results.multipliers)
    for name, body in results.bodies.items():
        tables |= _body_tables(results, name, body)
    names = {name: f"{safe_name(name)}.csv" for name in ["responses", *tables]}
    refuse_foreign(directory, list(names.values()))
    with own_set(directory, list(names.values()), instead_of=BY_BODY):
        files = [write_csv(directory / names["responses"], *response_table(results))]
        for name, (columns, values) in tables.items():
            rows = np.column_stack([results.times, values]).tolist()
            files.append(write_csv(directory / names[name], [time, *columns], rows))
    return files


def response_table(results: Results) -> tuple[list[str], list[list[str | float]]]:
    """Table with value, unit and gradient of every response: first line, and lines."""
    variables = list(next(iter(results.gradients.values()), {}))
    lines: list[list[str | float]] = [
        [name, value, results.response_units[name], *(results.gradients[name][x] for x in variables if name in results.gradients)]
        for name, value in results.responses.items()
    ]
    return ["response", "value", "unit", *(f"derivative by {x}" for x in variables)], lines


def _body_tables(results: Results, name: str, body: BodyResults) -> dict[str, tuple[list[str], np.ndarray]]:
    stress, length = results.unit("stress"), results.unit("length")
    points = [f"{point} in {stress}" for point in body.stress_points]
    nodes = [f"at arc length {place:.9g} in {length}" for place in body.arc_length]
    tables = {f"stress_{name}": (points, body.stress)}
    if nodes:
        tables[f"shape_error_{name}"] = (nodes, body.shape_error)
    for x, variable in enumerate(results.design):
        tables[f"stress_{name}_by_{variable}"] = (body.stress_points, body.dstress[:, :, x])
        if nodes:
            tables[f"shape_error_{name}_by_{variable}"] = (nodes, body.dshape_error[:, :, x])
    return tables


def write_csv(path: Path, head: Sequence[str], rows: Iterable[Sequence[object]]) -> Path:
    """Write one table, in one stroke; numbers with all their digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    write_whole(path, text.getvalue().encode())
    return path


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
