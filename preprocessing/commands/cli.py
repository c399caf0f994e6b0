"""The command `ffrf-preprocess`: build the reduced model of a skin, a meshed body or a frame, unless the file is there and up to date."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer

from preprocessing.input.output_file import refuse_output
from preprocessing.recipes.build_model import read_recipe
from toolkit.foundation.errors import InputError, ModelFileError, ToolkitError, out_of_memory, refusal
from toolkit.foundation.files.outside_files import told_outside
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.material_questions import material_questions

app = typer.Typer(pretty_exceptions_enable=False)


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"ffrf-toolkit {version('ffrf-toolkit')}")
        raise typer.Exit


@app.command()
def preprocess(
    skin: Annotated[
        Path, typer.Argument(metavar="BODY.toml", help="Description of a skin, of a body with a mesh or matrices, or of a frame.")
    ],
    force: Annotated[bool, typer.Option("--force", help="Build even if the inputs are unchanged.")] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace whatever file is there, even another body's model; inputs never.")
    ] = False,
    parameters: Annotated[
        list[str] | None, typer.Option("--parameter", metavar="NAME=VALUE", help="Another value of a parameter; repeatable.")
    ] = None,
    output: Annotated[Path | None, typer.Option(help="File to write; by default BODY.h5 next to BODY.toml.")] = None,
    extrude: Annotated[
        Path | None,
        typer.Option(metavar="SOLID.msh", help="Write a skin as a mesh of solid elements and its SOLID.toml, and stop."),
    ] = None,
    layers: Annotated[int, typer.Option(min=1, help="Elements across the width of the extruded skin.")] = 8,
    _version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Build the reduced model of a flexible body from its TOML file."""
    if extrude is not None:
        _extrude(skin, extrude, layers)
        return
    recipe, values = read_recipe(skin), _values(parameters or [])
    output = output or skin.with_suffix(".h5")
    wanted = recipe.hash(values)
    refuse_output(output, skin, recipe.inputs, wanted, overwrite)
    if not force and _hash_in(output, recipe.parts) == wanted:
        typer.echo(f"{output} is up to date: its inputs are unchanged. Use --force to build it again.")
        return
    if elsewhere := told_outside(skin, recipe.inputs):
        _remark(elsewhere)
    model = recipe.at(values).build(_remark)
    for caution in material_questions(model.nominal, model.units, skin.stem):
        _remark(f"warning: {caution.text}")
    save(model, output)
    interfaces = ", ".join(model.interfaces or {}) or "none"
    typer.echo(f"{output} written: {model.n_f} elastic coordinates, interface points {interfaces}.")


def main() -> None:
    """Run the command; errors of the toolkit become one plain message and exit code 1."""
    try:
        app()
    except ToolkitError as error:
        typer.echo(str(error), err=True)
        raise SystemExit(1) from None
    except OSError as error:
        typer.echo(refusal(error), err=True)
        raise SystemExit(1) from None
    except MemoryError as error:
        typer.echo(out_of_memory(error), err=True)
        raise SystemExit(1) from None


def _extrude(skin: Path, target: Path, layers: int) -> None:
    try:
        from preprocessing.recipes.solids.extruded_skin import extrude  # scikit-fem and meshio take a second
    except ImportError as error:
        raise InputError(
            f"a solid needs meshio and scikit-fem, which cannot be loaded ({error}). Install them with: pip install "
            "'ffrf-toolkit[preprocessing]'."
        ) from error
    mesh, recipe = extrude(skin, target, layers, _remark)
    typer.echo(f"{mesh} and {recipe} written. Next: ffrf-preprocess {recipe}")


def _values(given: list[str]) -> dict[str, float]:
    """Parameters and their values."""
    found = {}
    for text in given:
        name, _, value = text.partition("=")
        try:
            found[name.strip()] = float(value)
        except ValueError:
            raise InputError(f"--parameter {text!r}: write NAME=NUMBER, for example thickness=1.6.") from None
    return found


def _hash_in(path: Path, parts: tuple[str, ...]) -> str | None:
    """Input hash of the file that is there; None if there is none or it cannot be used as a whole."""
    if not path.exists():
        return None
    try:
        model = load(path)
    except ModelFileError as error:
        _remark(f"{error} It is built anew.")
        return None
    lacking = [part for part in parts if getattr(model, part) is None]
    if lacking:
        _remark(f"{str(path)!r} lacks {', '.join(lacking)}. It is built anew.")
    if not model.inputs:
        _remark(f"{str(path)!r} does not say what it was built from, as those of older versions. It is built anew.")
    return None if lacking or not model.inputs else model.input_hash


def _remark(text: str) -> None:
    typer.echo(text, err=True)
