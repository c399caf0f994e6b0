"""The command `ffrf-preprocess`: build the reduced model of a skin, a meshed body or a frame, unless the file is there and up to date."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from preprocessing.builders.build_model import read_recipe
from preprocessing.commands.body_picture import refuse_picture, save_picture
from preprocessing.mesh.input_files import refuse_output
from toolkit.foundation.errors import InputError, ModelFileError
from toolkit.foundation.files.safe_files import told_outside
from toolkit.foundation.rare_collections import last_work
from toolkit.foundation.terminal import AsJson, Quiet, Version, errors_in_words, print_json, usage_in_json
from toolkit.reduced_model.body_summary import NOT_KEPT, body_summary
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.model import ReducedModel
from toolkit.reduced_model.questions import (
    face_questions,
    face_record,
    material_questions,
    mesh_questions,
    mesh_record,
    told_faces,
    told_mesh,
)
from toolkit.reduced_model.told_body import body_line

app = typer.Typer(pretty_exceptions_enable=False)


class Command(TyperCommand):
    """Preprocessing command, which tells invalid input as JSON too, if that was asked for."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the command line."""
        with usage_in_json("--json" in args):
            return super().parse_args(ctx, args)


@app.command(cls=Command)
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
    picture: Annotated[
        Path | None,
        typer.Option(metavar="FILE.png", help="Draw the body, with its interface points, clamp and groups; needs matplotlib."),
    ] = None,
    layers: Annotated[int, typer.Option(min=1, help="Elements across the width of the extruded skin.")] = 8,
    as_json: AsJson = False,
    quiet: Quiet = False,
    _version: Version = False,
) -> None:
    """Build the reduced model of a flexible body from its TOML file."""
    remarks = Remarks(quiet)
    with errors_in_words(as_json):
        if extrude is not None:
            if picture is not None:
                raise InputError("--picture draws a reduced model, and --extrude builds none. Leave one of them out.")
            answer = _extruded(skin, extrude, layers, remarks)
        else:
            options = BuildOptions(force, overwrite, picture)
            answer = _built(skin, output or skin.with_suffix(".h5"), _values(parameters or []), options, remarks)
        if as_json:
            print_json({**answer.record, "remarks": remarks.said, "warnings": answer.warnings})
        else:
            typer.echo(answer.text)


def main() -> None:
    """Run the command."""
    with last_work():
        app()


class Remarks:
    """Remarks of a build, stored and printed on standard error unless nobody wants them."""

    def __init__(self, quiet: bool) -> None:
        self.said: list[str] = []
        self._quiet = quiet

    def __call__(self, text: str) -> None:
        """Store a remark, and print it."""
        self.said.append(text)
        self.only_say(text)

    def only_say(self, text: str) -> None:
        """Print something that is stored elsewhere."""
        if not self._quiet:
            typer.echo(text, err=True)


@dataclass(frozen=True)
class BuildOptions:
    """Options of a build: whether an up-to-date model, or another body's, may be replaced, and the picture to draw."""

    force: bool
    overwrite: bool
    picture: Path | None = None


@dataclass(frozen=True)
class BuildAnswer:
    """Answer of the command: sentences, the same as part of a JSON object, and the warnings that belong to it."""

    text: str
    record: dict[str, object]
    warnings: list[str] = field(default_factory=list)


def _built(path: Path, output: Path, values: dict[str, float], options: BuildOptions, remarks: Remarks) -> BuildAnswer:
    """Build a reduced model, unless it exists; cautions about its material belong to it in both cases."""
    recipe = read_recipe(path)
    refuse_output(output, path, recipe.inputs, wanted := recipe.hash(values), options.overwrite)
    if options.picture:
        refuse_picture(options.picture, options.overwrite)
    found = None if options.force else _up_to_date(output, recipe.parts, wanted, remarks)
    model = found
    if model is None:
        if elsewhere := told_outside(path, recipe.inputs):
            remarks(elsewhere)
        model = recipe.at(values).build(remarks)
        save(model, output)
    asked = (
        *material_questions(model.nominal, model.units, path.stem),
        *mesh_questions(model, path.stem),
        *face_questions(model, path.stem),
    )
    warnings = [*recipe.at(values).warnings, *(caution.text for caution in asked)]
    for text in warnings:
        if text not in remarks.said:
            remarks.only_say(f"warning: {text}")
    interfaces = list(model.interfaces or {})
    told = f"{output} written: {model.n_f} elastic coordinates, interface points {', '.join(interfaces) or 'none'}."
    if found is not None:
        told = f"{output} is up to date: its inputs are unchanged. Use --force to build it again."
    if stress := told_mesh(model):
        told += f"\nEstimated: {stress}."
    if faces := told_faces(model):
        told += f"\nAgainst the uncut mesh: {faces}."
    summary = body_summary(model)
    if options.picture:
        save_picture(model, path.stem, options.picture)
        told += f"\n{options.picture} drawn."
    told += f"\n{body_line(path.stem, summary)}{'' if model.composition else f' {NOT_KEPT}'}"
    record = {"file": str(output), "built": found is None, "elastic_coordinates": model.n_f, "interface_points": interfaces}
    record["stress_error"] = mesh_record(model)
    record["face_error"] = face_record(model)
    record["body"] = summary
    record["picture"] = str(options.picture) if options.picture else None
    return BuildAnswer(told, record, warnings)


def _extruded(skin: Path, target: Path, layers: int, remarks: Remarks) -> BuildAnswer:
    """Write a skin as a mesh of solid elements with its recipe."""
    try:
        from preprocessing.builders.extruded_skin import extrude  # scikit-fem and meshio take a second
    except ImportError as error:
        raise InputError(
            f"a solid needs meshio and scikit-fem, which cannot be loaded ({error}). Install them with: pip install "
            "'ffrf-toolkit[preprocessing]'."
        ) from error
    mesh, recipe = extrude(skin, target, layers, remarks)
    return BuildAnswer(f"{mesh} and {recipe} written. Next: ffrf-preprocess {recipe}", {"files": [str(mesh), str(recipe)]})


def _values(given: list[str]) -> dict[str, float]:
    """Values of the parameters that were set, by name."""
    found = {}
    for text in given:
        name, _, value = text.partition("=")
        try:
            found[name.strip()] = float(value)
        except ValueError:
            raise InputError(f"--parameter {text!r}: write NAME=NUMBER, for example thickness=1.6.") from None
    return found


def _up_to_date(path: Path, parts: tuple[str, ...], wanted: str, remarks: Remarks) -> ReducedModel | None:
    """Existing model, if it was built from the same input as a whole; otherwise None."""
    if not path.exists():
        return None
    try:
        model = load(path)
    except ModelFileError as error:
        remarks(f"{error} It is built anew.")
        return None
    lacking = [part for part in parts if getattr(model, part) is None]
    if lacking:
        remarks(f"{str(path)!r} lacks {', '.join(lacking)}. It is built anew.")
    if not model.inputs:
        remarks(f"{str(path)!r} does not say what it was built from, as those of older versions. It is built anew.")
    return model if not lacking and model.inputs and model.input_hash == wanted else None
