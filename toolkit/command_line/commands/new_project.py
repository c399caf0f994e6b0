"""`ffrf new`: projects of one's own.

They need airfoils or meshes read, which is preprocessing: `ffrf` hands over to the program that does it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from toolkit.foundation.processes import run
from toolkit.foundation.terminal import AsJson

PROGRAM = "preprocessing.projects.command"

app = typer.Typer(help="Start a project of your own.", no_args_is_help=True)

Folder = Annotated[Path, typer.Argument(metavar="MY_DIR", help="Folder to make.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing but warnings and errors.")]
System = Annotated[str, typer.Option(help="System of units: mm-t-s or m-kg-s.")]


@app.callback()
def projects() -> None:
    """Start a project of your own."""


@app.command()
def wing(
    folder: Folder,
    airfoil: Annotated[Path, typer.Option(metavar="FILE", help="The section, in any common format.")],
    target: Annotated[Path | None, typer.Option(metavar="FILE", help="The wanted section; by default the nose droops.")] = None,
    chord: Annotated[
        float | None, typer.Option(help="Chord in mm; by default 550, or the largest x of an airfoil in mm or m.")
    ] = None,
    units: Annotated[str | None, typer.Option(help="Of the airfoil's numbers: fraction, percent, mm or m.")] = None,
    target_units: Annotated[str | None, typer.Option(help="Of the target's numbers, if they are others.")] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Start a morphing wing from any airfoil file: skin, linkage, target and the next commands."""
    _start("wing", folder, as_json, quiet, airfoil=airfoil, target=target, chord=chord, units=units, target_units=target_units)


@app.command()
def linkage(folder: Folder, units: System = "mm-t-s", as_json: AsJson = False, quiet: Quiet = False) -> None:
    """Start a linkage of rods: a crank-rocker with a motor and a spring, and a study of it."""
    _start("linkage", folder, as_json, quiet, units=units)


@app.command()
def solid(
    folder: Folder,
    mesh: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A mesh with two named groups of nodes; by default an arm is drawn.")
    ] = None,
    clamp: Annotated[str, typer.Option(metavar="GROUP", help="Group of the mesh that sits on the motor.")] = "hub",
    grip: Annotated[str, typer.Option(metavar="GROUP", help="Group of the mesh that carries the weight.")] = "tip",
    units: System = "mm-t-s",
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Start a flexible solid on a motor, from a mesh of your own or an arm whose drawing can be changed."""
    _start("solid", folder, as_json, quiet, mesh=mesh, clamp=clamp, grip=grip, units=units)


def _start(kind: str, folder: Path, as_json: bool, quiet: bool, **options: object) -> None:
    """Run the program and print what it says; if quiet, warnings and errors alone."""
    given = [kind, str(folder)]
    for name, value in options.items():
        given += [] if value is None else [f"--{name.replace('_', '-')}", str(value)]
    done = run(PROGRAM, [*given, *(["--json"] if as_json else [])])
    if as_json or not quiet:
        typer.echo(done.stdout, nl=False)
    typer.echo(done.stderr, nl=False, err=True)
    if done.returncode:
        raise typer.Exit(done.returncode)
