"""What a long command says while it works, on standard error: a progress bar, and a note before code is compiled."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Literal

import typer
from rich.console import Console

if TYPE_CHECKING:
    from toolkit.foundation.compiled.compile_watch import CompileWatch
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
    """Rehearse an analysis, so that nothing is compiled in it.

    If that compiles anything, say so, show how far it has come, and compile what other analyses call too, so that no later command has to.
    """
    from toolkit.command_line.rehearsal import rehearse, rehearse_others

    with told_compilation(scene.dimension, quiet) as watch:
        rehearse(scene, kind, backwards)
        if watch.functions:
            rehearse_others(scene)


@contextmanager
def told_compilation(dimension: int, quiet: bool = False) -> Iterator[CompileWatch]:
    """Report compilation within this block, with its progress and, at the end, what was compiled."""
    from toolkit.foundation.compiled.compile_watch import watched_compilation
    from toolkit.foundation.compiled.compiled_code import is_kept

    functions, seconds = EXPECTED[dimension]
    with ExitStack() as shown:
        moves: list[Progress] = []

        def announce() -> None:
            if not quiet:
                typer.echo(
                    f"compiling the formulas for this machine, once for all commands: at most some {functions} functions, some "
                    f"{seconds} s of a free core ...",
                    err=True,
                )
            moves.append(shown.enter_context(bar("functions compiled", quiet)))

        with watched_compilation(announce, lambda done: moves[0](done, max(done, functions))) as watch:
            yield watch
    if watch.functions and not quiet:
        kept = "; they are kept on the disk" if is_kept() else ""  # elsewhere a warning has said what becomes of them
        typer.echo(f"{watch.functions} functions compiled in {watch.seconds:.0f} s{kept}.", err=True)


EXPECTED = {2: (220, 26), 3: (270, 38)}
"""Largest numbers of functions compiled, and of seconds it takes, by the dimension of space.

Measured by `python -m tests.benchmarks.first_run`, in processor time of a free core, which of a busy one is two fifths more: in the plane
212 functions in 20 s for a motion in any formulation, which an equilibrium shares, and 14 in 2 s for its adjoint; in space 261 in 30 s, and
13 in 2 s. Formulas of kinds of joints and loads come apart."""


@contextmanager
def bar(title: str, quiet: bool = False) -> Iterator[Progress]:
    """Progress bar on standard error with elapsed and remaining time, if that is a terminal and `quiet` is off."""
    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield lambda _done, _total: None
        return
    from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar  # for terminals alone

    times = TimeElapsedColumn(), TextColumn("left:"), TimeRemainingColumn()
    columns = SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), *times
    with Bar(*columns, console=console, transient=True) as shown:
        task = shown.add_task(title, total=None)
        yield lambda done, total: shown.update(task, completed=done, total=total)
