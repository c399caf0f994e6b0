"""The answer of a command: all that it has found out, in the four forms in which it is told.

`record()` is a JSON object for programs, `tables()` are tables and sentences for people, `figures()` are pictures, and `verdict` says
whether the numbers can be trusted. A command fills an `Answer`, and knows nothing of files, terminals or pages: `write` makes files of it,
`toolkit.command_line.printing.tell` prints it, and `toolkit.report.write` makes a page.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import finite
from toolkit.render.packages import RenderError, require

if TYPE_CHECKING:
    from toolkit.foundation.verdict import Verdict


Record = dict[str, Any]
"""JSON object; numbers in it that do not exist may be nan, and become null."""


@dataclass(frozen=True)
class AnswerTable:
    """Rows of numbers and words under a head.

    Attributes
    ----------
    head
        Names of the columns.
    rows
        Words stand as they are; numbers are shown with six digits.
    name
        Of its file NAME.csv, with all digits. A table of an answer that has a name is written and not printed.
    title, caption
        Heading and sentence on a page.
    wrap
        Letters after which words are broken on a terminal; by default none are.
    """

    head: Sequence[str]
    rows: Sequence[Sequence[Any]]
    name: str = ""
    title: str = ""
    caption: str = ""
    wrap: int | None = None

    def save(self, folder: Path) -> Path:
        """Write the table as CSV with all digits."""
        from toolkit.files.tables import write_csv

        return write_csv(folder / f"{self.name}.csv", self.head, self.rows)

    def record(self) -> Record:
        """Table as a record for JSON."""
        return {"title": self.title, "head": list(self.head), "rows": self.rows}


class Picture(Protocol):
    """Figure of an answer, for example a `Drawing`."""

    def save(self, folder: Path) -> list[Path]:
        """Write its files, and return their paths."""
        ...


@dataclass(frozen=True)
class Answer:
    """What was found, and how it is told.

    Attributes
    ----------
    result
        Result of the analysis or study; every kind of answer states its class.
    verdict
        Whether its numbers can be trusted.
    """

    result: Any
    verdict: Verdict

    name = ""
    """Name of its JSON file."""
    written = "{files} are written."
    """Sentence on its files in their folder; without one their names are printed after the answer."""

    def record(self) -> Record:
        """JSON object; by default the record that the result itself has."""
        own: Record = self.result.record()
        return own

    def tables(self) -> Iterable[AnswerTable | str]:
        """Tables and sentences, in the order in which they are read."""
        return ()

    def figures(self) -> Iterable[Picture]:
        """Pictures, drawn one after the other."""
        return ()


def write(
    answer: Answer,
    folder: Path,
    pictures: bool = True,
    note: Callable[[str], None] | None = None,
    tables: str = "",
    figures: str = "",
) -> list[Path]:
    """Write the tables of an answer that have names, its record, and its figures; returns the files.

    Parameters
    ----------
    pictures
        Whether figures are drawn.
    note
        Is told why there are none where they cannot be drawn, if the answer without them is enough; otherwise that is an error.
    tables, figures
        Folders for these in the folder, which exist.
    """
    files = [each.save(folder / tables) for each in answer.tables() if isinstance(each, AnswerTable) and each.name]
    files.append(write_json(folder / f"{answer.name}.json", answer.record()))
    if not pictures:
        return files
    try:
        require("matplotlib")
        files += [file for each in answer.figures() for file in each.save(folder / figures)]
    except ToolkitError as error:
        if note is None:
            raise
        note(f"{'no' if isinstance(error, RenderError) else 'not all'} pictures: {error}")
    return files


def write_json(path: Path, record: Record) -> Path:
    """Write a record as one JSON object, in one stroke."""
    from toolkit.foundation.files.safe_files import write_whole

    write_whole(path, (json.dumps(finite(record), indent=2, allow_nan=False) + "\n").encode())
    return path
