"""A sweep's table as CSV and Parquet files."""

from __future__ import annotations

import csv
import io
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.replaced_file import write_whole


def write_csv(columns: dict[str, list[Any]], path: Path) -> None:
    """A table with all digits; what does not exist is an empty cell."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_cell(value) for value in row] for row in zip(*columns.values(), strict=True))
    write_whole(path, text.getvalue().encode())


def _cell(value: Any) -> Any:
    return "" if isinstance(value, float) and value != value else value


def write_parquet(columns: dict[str, list[Any]], path: Path) -> None:
    """The same table for programs that read columns; what does not exist is null.

    Raises
    ------
    InputError
        pyarrow is not installed.
    """
    if not has_parquet():
        raise InputError(
            "Parquet needs the package pyarrow, which is not installed. Install: pip install 'ffrf-toolkit[studies]'."
        )
    import pyarrow
    from pyarrow import parquet

    arrays = {
        name: [None if isinstance(value, float) and value != value else value for value in each] for name, each in columns.items()
    }
    content = io.BytesIO()
    parquet.write_table(pyarrow.table(arrays), content)
    write_whole(path, content.getvalue())


def has_parquet() -> bool:
    """Whether such files can be written."""
    return find_spec("pyarrow") is not None
