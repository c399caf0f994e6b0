"""The command `ffrf-preprocess`: build the reduced model of a skin, unless the file is there and up to date."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from preprocessing.build import build, input_hash
from preprocessing.skin_file import read_skin_file
from toolkit.errors import InputError, ModelFileError, ToolkitError
from toolkit.reduced_model_file import load, save

app = typer.Typer(pretty_exceptions_enable=False)


@app.command()
def preprocess(
    skin: Annotated[Path, typer.Argument(metavar="SKIN.toml", help="Description of the skin.")],
    force: Annotated[bool, typer.Option("--force", help="Build even if the inputs are unchanged.")] = False,
    output: Annotated[Path | None, typer.Option(help="File to write; by default SKIN.h5 next to SKIN.toml.")] = None,
) -> None:
    """Build the reduced model of a flexible skin from its TOML file."""
    file = read_skin_file(skin)
    output = output or skin.with_suffix(".h5")
    if output.resolve() == skin.resolve():
        raise InputError(f"{str(skin)!r} would be overwritten by its own reduced model. Name another file with --output.")
    if not force and _hash_in(output) == input_hash(skin, file):
        typer.echo(f"{output} is up to date: its inputs are unchanged. Use --force to build it again.")
        return
    model = build(skin, remark=_remark)
    try:
        save(model, output)
    except OSError as error:
        raise InputError(f"{str(output)!r} cannot be written ({error.strerror}). Give a writable place with --output.") from error
    interfaces = ", ".join(model.interfaces or {}) or "none"
    typer.echo(f"{output} written: {model.n_f} elastic coordinates, interface points {interfaces}.")


def main() -> None:
    """Run the command; errors of the toolkit become one plain message and exit code 1."""
    try:
        app()
    except ToolkitError as error:
        typer.echo(str(error), err=True)
        raise SystemExit(1) from None


def _hash_in(path: Path) -> str | None:
    """Input hash of the file that is there; None if there is none or it cannot be used."""
    if not path.exists():
        return None
    try:
        return load(path, parts=()).input_hash
    except ModelFileError as error:
        _remark(f"{error} It is built anew.")
        return None


def _remark(text: str) -> None:
    typer.echo(text, err=True)
