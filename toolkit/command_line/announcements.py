"""What a long command says while it works, on standard error: a progress bar, and a note before code is compiled."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Literal

import typer
from rich.console import Console
from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

if TYPE_CHECKING:
    from toolkit.scene.scene import Scene

Kind = Literal["transient", "static"]
Progress = Callable[[int, int], None]
BACKWARDS = ("auto", "adjoint")
"""Methods that may run backwards."""


@contextmanager
def at_work(
    title: str, scene: Scene, kind: Kind, design: Sequence[str] = (), quiet: bool = False, method: str = "direct"
) -> Iterator[Progress]:
    """Show a bar that moves with the calls (done, in all) of the function given back; it vanishes at the end.

    All that the analysis of the scene calls is compiled before, if it never was on this machine, and it is said so; `method` is that of
    gradients by the variables in `design`.
    """
    from toolkit.foundation.compiled.compiled_code import CompiledCodeWarning

    with warnings.catch_warnings():
        if quiet:
            warnings.simplefilter("ignore", CompiledCodeWarning)
        compile_before(scene, kind, bool(design) and kind == "transient" and method in BACKWARDS, quiet)
        with bar(title, quiet) as progress:
            yield progress


def compile_before(scene: Scene, kind: Kind, backwards: bool = False, quiet: bool = False) -> None:
    """Rehearse an analysis, so that nothing is compiled in it, and say so if that compiles anything."""
    from toolkit.command_line.rehearsal import rehearse
    from toolkit.foundation.compiled.compile_watch import watched_compilation
    from toolkit.foundation.compiled.compiled_code import is_kept

    def announce() -> None:
        if not quiet:
            typer.echo(f"compiling the formulas for this machine, once, {EXPECTED[scene.dimension]} ...", err=True)

    with watched_compilation(announce) as watch:
        rehearse(scene, kind, backwards)
    if watch.functions and not quiet:
        kept = "; they are kept on the disk" if is_kept() else ""  # elsewhere a warning has said what becomes of them
        typer.echo(f"{watch.functions} functions compiled in {watch.seconds:.0f} s{kept}.", err=True)


EXPECTED = {2: "up to three minutes on a free core", 3: "up to five minutes on a free core"}
"""How long it takes at most to compile all that one command calls, by the dimension of space.

Measured, in processor time of a common server: in the plane 95 functions in 74 s for an equilibrium, 34 more in 37 s for a motion, 7 in
12 s for its adjoint, 14 in 34 s for stabilised index 2; in space 115 in 137 s, 25 in 61 s, 7 in 16 s and 13 in 76 s."""


@contextmanager
def bar(title: str, quiet: bool = False) -> Iterator[Progress]:
    """A bar on standard error, with the time that went and that is left, if that is a terminal and nobody asked for quiet."""
    console = Console(stderr=True)
    times = TimeElapsedColumn(), TextColumn("left:"), TimeRemainingColumn()
    columns = SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), *times
    with Bar(*columns, console=console, transient=True, disable=quiet or not console.is_terminal) as shown:
        task = shown.add_task(title, total=None)
        yield lambda done, total: shown.update(task, completed=done, total=total)
