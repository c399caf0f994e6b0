"""The programs behind `ffrf new`, which runs them in a process of their own (`python -m preprocessing.projects.command`)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from toolkit.foundation.terminal import AsJson, errors_in_words, print_json

app = typer.Typer(pretty_exceptions_enable=False)
Folder = Annotated[Path, typer.Argument()]


@app.command()
def wing(
    folder: Folder,
    airfoil: Annotated[Path, typer.Option()],
    target: Annotated[Path | None, typer.Option()] = None,
    chord: Annotated[float | None, typer.Option()] = None,
    units: Annotated[str | None, typer.Option()] = None,
    target_units: Annotated[str | None, typer.Option()] = None,
    as_json: AsJson = False,
) -> None:
    """Write the files of a new wing and say what to do with them."""
    from preprocessing.projects.new_wing import new_wing

    told = "The target is a droop of the nose; replace target.dat by a section of your own, in the same frame, when you have one."
    following = (f"ffrf-preprocess {folder}/skin.toml", f"ffrf statics {folder}/scene.toml", f"ffrf optimize {folder}/study.toml")
    _tell(
        lambda: new_wing(folder, airfoil, target, chord, units, target_units),
        following,
        as_json,
        told if target is None else "",
    )


@app.command()
def linkage(folder: Folder, units: Annotated[str, typer.Option()] = "mm-t-s", as_json: AsJson = False) -> None:
    """Write the files of a new linkage and say what to do with them."""
    from preprocessing.projects.new_linkage import new_linkage

    following = (f"ffrf simulate {folder}/scene.toml", f"ffrf sensitivity {folder}/scene.toml")
    _tell(lambda: new_linkage(folder, units), following, as_json)


@app.command()
def solid(
    folder: Folder,
    mesh: Annotated[Path | None, typer.Option()] = None,
    clamp: Annotated[str, typer.Option()] = "hub",
    grip: Annotated[str, typer.Option()] = "tip",
    units: Annotated[str, typer.Option()] = "mm-t-s",
    as_json: AsJson = False,
) -> None:
    """Write the files of a new solid and say what to do with them."""
    from preprocessing.projects.new_solid import new_solid, size_question

    following = (f"ffrf-preprocess {folder}/body.toml", f"ffrf statics {folder}/scene.toml", f"ffrf simulate {folder}/scene.toml")
    _tell(
        lambda: new_solid(folder, mesh, clamp, grip, units),
        following,
        as_json,
        asked=lambda: size_question(mesh, units) if mesh else "",
    )


def _tell(
    made: Callable[[], list[Path]],
    following: tuple[str, ...],
    as_json: bool,
    remark: str = "",
    asked: Callable[[], str] = lambda: "",
) -> None:
    """Make a folder; print its files, the question that it raises, and what comes next."""
    with errors_in_words(as_json):
        files = [str(file) for file in made()]
        if warning := asked():
            typer.echo(f"warning: {warning}", err=True)
        if as_json:
            print_json({"files": files, "next": list(following), "warnings": [warning] if warning else []})
            return
        typer.echo("\n".join(f"{file} written." for file in files))
        if remark:
            typer.echo(remark)
        typer.echo(f"Next: {', then '.join(following)}; README.md has more.")


if __name__ == "__main__":
    app()
