"""The program behind `ffrf new wing`, which runs it in a process of its own (`python -m preprocessing.wings.command`)."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from preprocessing.wings.new_wing import REFERENCE_CHORD, new_wing
from toolkit.foundation.terminal import AsJson, errors_in_words, print_json


def command(
    folder: Annotated[Path, typer.Argument()],
    airfoil: Annotated[Path, typer.Option()],
    target: Annotated[Path | None, typer.Option()] = None,
    chord: Annotated[float, typer.Option()] = REFERENCE_CHORD,
    as_json: AsJson = False,
) -> None:
    """Write the files of a new wing and say what to do with them."""
    with errors_in_words(as_json):
        files = [str(file) for file in new_wing(folder, airfoil, target, chord)]
        following = [
            f"ffrf-preprocess {folder}/skin.toml",
            f"ffrf statics {folder}/scene.toml",
            f"ffrf optimize {folder}/study.toml",
        ]
        if as_json:
            print_json({"files": files, "next": following})
            return
        typer.echo("\n".join(f"{file} written." for file in files))
        if target is None:
            typer.echo(
                "The target is a droop of the nose; replace target.dat by a section of your own, in the same frame, when you have one."
            )
        typer.echo(f"Next: {', then '.join(following)}; README.md has more.")


if __name__ == "__main__":
    typer.run(command)
