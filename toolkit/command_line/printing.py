"""How every command tells its answer: files in a folder, one JSON object, or tables with the verdict below them."""

from __future__ import annotations

import atexit
from collections.abc import Sequence
from pathlib import Path

import typer
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table as RichTable
from rich.text import Text

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import leave_nothing, list_own, missing, refuse_foreign
from toolkit.foundation.terminal import print_json
from toolkit.foundation.verdict import PAGE, Verdict
from toolkit.report.answer import Answer, AnswerTable, write

OUTPUT_COLUMNS = 1000
"""Columns of the output: a number that the terminal wraps is better than one that is cut."""
LEFT = ("unit", "by", "why")
"""Columns of words."""


def tell(
    answer: Answer, as_json: bool, quiet: bool, folder: Path | None = None, pictures: bool = True, more: Sequence[Path] = ()
) -> None:
    """Write an answer into a folder, if there is one, and print it with its verdict: one JSON object, or tables and sentences.

    Parameters
    ----------
    pictures
        Whether figures are drawn into the folder.
    more
        Files that the command has written there itself.
    """
    files = [] if folder is None else [*write(answer, folder, pictures, lambda text: note(text, quiet)), *more]
    if files and answer.written:
        note(answer.written.format(files=", ".join(map(str, files)), folder=folder), quiet)
    if as_json:
        print_record(answer, quiet)
    else:
        print_tables(answer)
        typer.echo(verdict_text(answer.verdict))
    if not answer.written:
        for file in files:
            typer.echo(str(file), err=as_json)


def note(text: str, quiet: bool) -> None:
    """Say something on standard error, unless nobody wants it."""
    if not quiet:
        typer.echo(text, err=True)


def print_record(answer: Answer, quiet: bool) -> None:
    """Print an answer as one JSON object, and its cautions on standard error."""
    print_json(answer.record())
    warn(answer.verdict, quiet)


def print_tables(answer: Answer) -> None:
    """Print tables and sentences of an answer; tables with names are files."""
    for part in answer.tables():
        if isinstance(part, str):
            typer.echo(part)
        elif not part.name:
            Console(width=OUTPUT_COLUMNS, highlight=False).print(rich_table(part))


def rich_table(content: AnswerTable) -> RichTable:
    """Table for the terminal: columns of words to the left, of numbers to the right with six digits."""
    shown = RichTable(box=SIMPLE)
    for k, head in enumerate(content.head):
        left = k == 0 or content.wrap or head in LEFT
        shown.add_column(Text(head), justify="left" if left else "right", max_width=content.wrap)
    for row in content.rows:
        shown.add_row(*(Text(f"{cell:.6g}" if isinstance(cell, float) else str(cell)) for cell in row))
    return shown


def verdict_text(verdict: Verdict) -> str:
    """Whether the numbers can be trusted, all cautions, and where their codes are explained."""
    codes = f"\nCodes: {', '.join(verdict.codes)}. What they mean: {PAGE}." if verdict.codes else ""
    return f"{verdict}{codes}"


def warn(verdict: Verdict, quiet: bool = False) -> None:
    """Print a verdict on standard error, where standard output belongs to JSON or to names of files."""
    for caution in () if quiet else verdict.warnings:
        typer.echo(f"{'warning' if caution.doubt else 'note'}: {caution.text}", err=True)


def print_files(files: Sequence[Path], verdict: Verdict, as_json: bool, quiet: bool = False) -> None:
    """Print the names of files that show a run, and the cautions about it."""
    if as_json:
        print_json({"files": [str(file) for file in files], **verdict.record()})
    else:
        typer.echo("\n".join(str(file) for file in files))
    warn(verdict, quiet)


def prepare_folder(path: Path, *names: str) -> Path:
    """Make the folder for results before anything long begins; it is removed at the end if the command leaves it empty.

    Parameters
    ----------
    names : what the command will write there

    Raises
    ------
    InputError
        It cannot be made, or it is a file; or something is there by one of the names that no command has written.
    """
    made = missing(path)
    refuse_foreign(path, names)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be made a folder ({error.strerror}). Give another with --output.") from error
    atexit.register(leave_nothing, path, made)
    list_own(path, names)
    return path
