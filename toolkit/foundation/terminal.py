"""Parts that `ffrf` and `ffrf-preprocess` share on the terminal: options, JSON, and errors as one plain message."""

from __future__ import annotations

import errno
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Annotated, Any

import typer

from toolkit.foundation.errors import ToolkitError, out_of_memory, refusal
from toolkit.foundation.verdict import finite

INTERRUPTED = 130
"""Exit code of a command that Ctrl-C ended, as shells have it."""


def show_version(wanted: bool) -> None:
    """Print the version of the toolkit, and end."""
    if wanted:
        from importlib.metadata import version

        typer.echo(f"ffrf-toolkit {version('ffrf-toolkit')}")
        raise typer.Exit


Version = Annotated[bool, typer.Option("--version", callback=show_version, is_eager=True, help="Print the version and exit.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress and no remarks on standard error, only errors.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else on standard output.")]


def print_json(record: Mapping[str, object]) -> None:
    """Print one JSON object; numbers in it that are not finite become null."""
    typer.echo(json.dumps(finite(record), indent=2, allow_nan=False))


UsageError: Any = typer.BadParameter.__base__
"""Error that typer raises where a command line is invalid."""


@contextmanager
def usage_in_json(as_json: bool) -> Iterator[None]:
    """Context in which an invalid command line is told as JSON too, where that was asked for; the exit code stays typer's, 2."""
    try:
        yield
    except UsageError as error:
        error.message = error.message.removeprefix("Value error, ")  # of choices, where typer lets pydantic check them
        if as_json:
            print_json({"error": error.format_message()})
        raise


@contextmanager
def errors_in_words(as_json: bool) -> Iterator[None]:
    """Context in which an error of the toolkit becomes one plain message on standard error and exit code 1.

    Where JSON was asked for, it becomes an object too. So does Ctrl-C, with a code of its own.
    """
    try:
        yield
    except ToolkitError as error:
        raise _failed(str(error), as_json) from None
    except OSError as error:
        if error.errno == errno.EPIPE:  # whoever read the output has seen enough
            raise
        raise _failed(refusal(error), as_json) from None
    except MemoryError as error:
        raise _failed(out_of_memory(error), as_json) from None
    except KeyboardInterrupt:
        raise _failed("interrupted: files that were finished are kept, none is half written.", as_json, INTERRUPTED) from None


@contextmanager
def answered() -> Iterator[None]:
    """Context in which errors after a printed answer go to standard error alone, with exit code 1.

    One JSON object is enough.
    """
    try:
        yield
    except ToolkitError as error:
        raise _failed(str(error), as_json=False) from None


def _failed(message: str, as_json: bool, code: int = 1) -> typer.Exit:
    """Print what went wrong, and return the exit to raise."""
    typer.echo(message, err=True)
    if as_json:
        print_json({"error": message})
    return typer.Exit(code)
