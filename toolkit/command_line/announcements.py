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
    from numba.core.registry import CPUDispatcher

    from toolkit.scene import Scene
    from toolkit.system import System

Kind = Literal["transient", "static"]
Progress = Callable[[int, int], None]


@contextmanager
def at_work(title: str, scene: Scene, kind: Kind, design: Sequence[str] = (), quiet: bool = False) -> Iterator[Progress]:
    """Show a bar that moves with the calls (done, in all) of the function given back; it vanishes at the end.

    Formulas that were never compiled on this machine are compiled before, and it is said so.
    """
    from toolkit.compiled_code import CompiledCodeWarning
    from toolkit.kernel import is_on_disk
    from toolkit.sensitivity.analysis import prepare

    with warnings.catch_warnings():
        if quiet:
            warnings.simplefilter("ignore", CompiledCodeWarning)
        if not is_on_disk(kernel_of(kind)):
            system = prepare(scene, list(design))
            if not quiet:
                typer.echo("compiling the formulas for this machine, once, up to a minute ...", err=True)
            with bar("compiling", quiet):
                compile_formulas(system, kind)
        with bar(title, quiet) as progress:
            yield progress


@contextmanager
def bar(title: str, quiet: bool = False) -> Iterator[Progress]:
    """A bar on standard error, with the time that went and that is left, if that is a terminal and nobody asked for quiet."""
    console = Console(stderr=True)
    times = TimeElapsedColumn(), TextColumn("left:"), TimeRemainingColumn()
    columns = SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), *times
    with Bar(*columns, console=console, transient=True, disable=quiet or not console.is_terminal) as shown:
        task = shown.add_task(title, total=None)
        yield lambda done, total: shown.update(task, completed=done, total=total)


def compile_formulas(system: System, kind: Kind) -> None:
    """Compile what an analysis calls, by one equilibrium or one time step."""
    from toolkit.run_options import RunOptions
    from toolkit.solvers.statics import solve_statics
    from toolkit.solvers.transient import simulate
    from toolkit.validity.energy_balance import energy_balance

    options = system.scene.solver
    if kind == "static":
        solve_statics(system, options)
    else:
        plain = {"times": None, "local_error": None, "memory": RunOptions().memory}  # two states fit anywhere
        short = options.model_copy(update={"end_time": options.step, **plain})
        energy_balance(simulate(system, short))


def kernel_of(kind: Kind) -> CPUDispatcher:
    """The compiled function that an analysis calls, with everything below it."""
    if kind == "static":
        from toolkit.equations import evaluate_all

        return evaluate_all
    from toolkit.solvers.generalized_alpha import integrate

    return integrate
