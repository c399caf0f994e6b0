"""The program behind `ffrf new wing`, which runs it in a process of its own (`python -m preprocessing.wings.command`)."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from preprocessing.wings.new_wing import REFERENCE_CHORD, new_wing
from toolkit.foundation.errors import ToolkitError, refusal


def command(
    folder: Annotated[Path, typer.Argument()],
    airfoil: Annotated[Path, typer.Option()],
    target: Annotated[Path | None, typer.Option()] = None,
    chord: Annotated[float, typer.Option()] = REFERENCE_CHORD,
) -> None:
    """Write the files of a new wing and say what to do with them."""
    try:
        files = new_wing(folder, airfoil, target, chord)
    except ToolkitError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(1) from None
    except OSError as error:
        typer.echo(refusal(error), err=True)
        raise typer.Exit(1) from None
    typer.echo("\n".join(f"{file} written." for file in files))
    if target is None:
        typer.echo(
            "The target is a droop of the nose; replace target.dat by a section of your own, in the same frame, when you have one."
        )
    typer.echo(
        f"Next: ffrf-preprocess {folder}/skin.toml, then ffrf statics {folder}/scene.toml and ffrf optimize {folder}/study.toml; "
        "README.md has more."
    )


if __name__ == "__main__":
    typer.run(command)
