"""What a long command says while it works, on standard error: a progress bar, and a note before code is compiled."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

if TYPE_CHECKING:
    from numba.core.registry import CPUDispatcher


@contextmanager
def at_work(title: str, kind: Literal["transient", "static"]) -> Iterator[Callable[[int, int], None]]:
    """Show a bar that moves with the calls (done, in all) of the function given back; it vanishes at the end."""
    if not is_compiled(kernel_of(kind)):
        typer.echo("compiling the formulas for this machine, once, about a minute ...", err=True)
    columns = SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def kernel_of(kind: Literal["transient", "static"]) -> CPUDispatcher:
    """The compiled function that an analysis calls, with everything below it."""
    if kind == "static":
        from toolkit.equations import evaluate

        return evaluate
    from toolkit.solvers.generalized_alpha import integrate

    return integrate


def is_compiled(kernel: CPUDispatcher) -> bool:
    """Whether numba's cache on disk, wherever it is, has an index of this function for this Python."""
    code = kernel.py_func.__code__
    name = f"{Path(code.co_filename).stem}.{code.co_qualname}-{code.co_firstlineno}"
    version = f"py{sys.version_info.major}{sys.version_info.minor}"
    return any(Path(kernel.stats.cache_path).glob(f"{name}.{version}*.nbi"))
