"""`ffrf new`: projects of one's own.

A new wing needs its airfoil read, which is preprocessing: `ffrf` hands over to the program that does it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from toolkit.foundation.processes.preprocessing_process import run
from toolkit.foundation.terminal import AsJson

PROGRAM = "preprocessing.wings.command"

app = typer.Typer(help="Start a project of your own.", no_args_is_help=True)


@app.callback()
def projects() -> None:
    """Start a project of your own."""


@app.command()
def wing(
    folder: Annotated[Path, typer.Argument(metavar="MY_DIR", help="Folder to make.")],
    airfoil: Annotated[Path, typer.Option(metavar="FILE", help="The section, in any common format, in fractions of the chord.")],
    target: Annotated[Path | None, typer.Option(metavar="FILE", help="The wanted section; by default the nose droops.")] = None,
    chord: Annotated[float, typer.Option(help="Chord in mm.")] = 550.0,
    as_json: AsJson = False,
) -> None:
    """Start a morphing wing from any airfoil file: skin, linkage, target and the next commands."""
    given = [str(folder), "--airfoil", str(airfoil), "--chord", str(chord), *(["--target", str(target)] if target else [])]
    given += ["--json"] if as_json else []
    done = run(PROGRAM, given)
    typer.echo(done.stdout, nl=False)
    typer.echo(done.stderr, nl=False, err=True)
    if done.returncode:
        raise typer.Exit(done.returncode)
