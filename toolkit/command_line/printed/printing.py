"""What all commands print alike: JSON, tables, and whether the numbers can be trusted."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from toolkit.foundation.terminal import print_json

if TYPE_CHECKING:
    from toolkit.foundation.verdict import Verdict

WIDE = 1000
"""Columns of the output: a number that the terminal wraps is better than one that is cut."""
LEFT = ("unit", "by", "why")
"""Columns of words."""


def print_verdict(verdict: Verdict) -> None:
    """Print whether the numbers can be trusted, all cautions, and where their codes are explained."""
    from toolkit.foundation.verdict import PAGE

    said = [str(verdict), *([f"Codes: {', '.join(verdict.codes)}. What they mean: {PAGE}."] if verdict.codes else [])]
    Console(width=WIDE, highlight=False).print("\n".join(said), markup=False)


def warn(verdict: Verdict, quiet: bool = False) -> None:
    """Print a verdict on standard error, where standard output belongs to JSON or to names of files."""
    for caution in () if quiet else verdict.warnings:
        typer.echo(f"{'warning' if caution.doubt else 'note'}: {caution.text}", err=True)


def print_answer(
    record: Callable[[], dict[str, Any]], shown: Callable[[], None], verdict: Verdict, as_json: bool, quiet: bool
) -> None:
    """Print an answer with its verdict: one JSON object, or tables; cautions are in both."""
    if as_json:
        print_json(record())
        warn(verdict, quiet)
    else:
        shown()
        print_verdict(verdict)


def print_files(files: Sequence[Path], verdict: Verdict, as_json: bool, quiet: bool = False) -> None:
    """Print the names of files that show a run, and the cautions about it."""
    if as_json:
        print_json({"files": [str(file) for file in files], **verdict.record()})
    else:
        typer.echo("\n".join(str(file) for file in files))
    warn(verdict, quiet)


def table(first: str, *others: str) -> Table:
    """Empty table with a column of words and columns of numbers."""
    made = Table(box=SIMPLE)
    made.add_column(first)
    for name in others:
        made.add_column(name, justify="left" if name in LEFT else "right")
    return made


def finite_or_none(value: float) -> float | None:
    """Number, or None if it is not finite: JSON has no nan."""
    return value if math.isfinite(value) else None
