"""`ffrf new`: projects of one's own.

A new wing needs its airfoil read, which is preprocessing, and the runtime never imports that. So, as `git` does with its commands,
`ffrf` hands over to the program that does it, in a process of its own; an installation without preprocessing says what is missing.
"""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

import toolkit
from toolkit.errors import InputError

PROGRAM = "preprocessing.new_wing_command"

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
) -> None:
    """Start a morphing wing from any airfoil file: skin, linkage, target and the next commands."""
    if find_spec(PROGRAM.partition(".")[0]) is None:
        raise InputError(
            "a new wing needs the preprocessing. Install it: pip install '.[preprocessing]' in the project's folder."
        )
    given = [str(folder), "--airfoil", str(airfoil), "--chord", str(chord), *(["--target", str(target)] if target else [])]
    here = str(Path(toolkit.__file__ or "").parents[1])  # both programs shall be of one version
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [here, os.environ.get("PYTHONPATH")]))}
    done = subprocess.run([sys.executable, "-m", PROGRAM, *given], env=environment, capture_output=True, text=True, check=False)
    typer.echo(done.stdout, nl=False)
    typer.echo(done.stderr, nl=False, err=True)
    if done.returncode:
        raise typer.Exit(done.returncode)
