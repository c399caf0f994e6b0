"""What is in a file: a reduced model, results, or a scene with every number that can be a design variable."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.reduced_model.description.told_body import body_lines

if TYPE_CHECKING:
    from toolkit.foundation.verdict import Verdict
    from toolkit.results.results import Results
    from toolkit.scene.scene import Scene


NOT_SOLVED = "the scene is judged as it is written, and was not solved: ffrf statics and ffrf simulate judge what comes of it."
"""What nobody should take this verdict for."""


def describe(path: Path) -> dict[str, Any]:
    """Content of a results file, or of a reduced model (anything else), as a record.

    Raises
    ------
    InputError, ModelFileError, ResultsFileError
        The file is missing or is none of them.
    """
    from toolkit.door.describe import describe as describe_model
    from toolkit.foundation.files.hdf5 import schema_of
    from toolkit.kept_run.layout import SCHEMA
    from toolkit.reduced_model.file import is_reduced_model

    if path.is_file() and schema_of(path) == SCHEMA:
        from toolkit.results.results_file import load_results

        return describe_results(load_results(path))
    if path.suffix != ".h5" and not is_reduced_model(path):
        what = "is" if path.is_file() else "is a folder," if path.is_dir() else "does not exist; it is"
        raise InputError(
            f"{str(path)!r} {what} neither a scene (.toml) nor a reduced model or results (.h5). Give the path of one of them."
        )
    return describe_model(path)


def describe_results(results: Results) -> dict[str, Any]:
    """Record of stored results: what was computed, of what, with which settings."""
    from toolkit.command_line.printed.printing import finite_or_none
    from toolkit.kept_run.layout import SCHEMA, SCHEMA_VERSION

    values, gradients = results.responses.items(), results.gradients.items()
    return {
        "schema": f"{SCHEMA}, version {SCHEMA_VERSION}",
        "analysis": results.kind,
        "units": results.units,
        "times": {"from": results.times[0], "to": results.times[-1], "steps": len(results.times) - 1},
        "sizes": {"coordinates": len(results.coordinates), "multipliers": len(results.multiplier_names)},
        "bodies": {
            name: {"stress points": body.stress.shape[1], "points with a target": body.shape_error.shape[1]}
            for name, body in results.bodies.items()
        },
        "responses": {name: {"value": finite_or_none(value), "unit": results.response_units[name]} for name, value in values},
        "method": results.method,
        "gradients": {name: {x: finite_or_none(slope) for x, slope in slopes.items()} for name, slopes in gradients},
        "derivatives_of_states_by": ", ".join(results.design),
        "variables": results.variables,
        "settings": {key: value for key, value in results.settings.items() if not isinstance(value, dict)},
        "run": results.run,
        **results.verdict.record(),
        "scene": {"sha256": results.scene.sha256, "changes": ", ".join(f"{k}={v}" for k, v in results.scene.changes.items())},
        "models": dict(results.scene.models),
        "writers": results.writers,
    }


def describe_scene(scene: Scene) -> dict[str, Any]:
    """Record of a scene: names and kinds of all parts, design variables, numbers that could be one, and questions."""
    from toolkit.foundation.files.outside_files import outside_files
    from toolkit.scene.resolution import loaded
    from toolkit.sensitivity.preparation import responses_of
    from toolkit.validity.description.frame_choice import frame_choices

    try:
        frames = {body: choice.words for body, choice in frame_choices(scene).items()}
    except ToolkitError:  # which is said below
        frames = {}
    outside = outside_files(scene.directory / "scene", scene.read_files())
    groups: dict[str, Mapping[str, Any]] = {"bodies": loaded(scene).written.bodies, "joints": scene.joints, "loads": scene.loads}
    return {
        "units": scene.units,
        "dimension": scene.dimension,
        **({"files outside of the scene's folder": ", ".join(outside)} if outside else {}),
        **{group: {name: part.kind for name, part in parts.items()} for group, parts in groups.items()},
        **({"reference_conditions": frames} if frames else {}),
        "responses": {name: {"type": each.kind, "unit": each.unit(scene.units)} for name, each in responses_of(scene).items()},
        "design": {each.name: each.record() for each in scene.design_variables()},
        "paths": {path: float(scene.number(path)) for path in scene.available_paths()},
        **_questions(scene).record(),
    }


def _questions(scene: Scene) -> Verdict:
    """Questions about a scene before it runs; of one that cannot be compiled, the reason."""
    from toolkit.foundation.verdict import Caution, Verdict
    from toolkit.system.system import compile_scene
    from toolkit.validity.description.scene_cautions import cautions_of_scene

    try:
        compile_scene(scene)
        return Verdict.of([*cautions_of_scene(scene), Caution("not-solved", NOT_SOLVED, doubt=False)])
    except ToolkitError as error:
        return Verdict.of([Caution("cannot-be-compiled", str(error))])


def print_file(record: dict[str, Any]) -> None:
    """Print the content of a file, and at the end the verdict that was kept in it."""
    from toolkit.command_line.printed.printing import print_verdict
    from toolkit.foundation.verdict import Verdict

    judged: dict[str, Any] = {key: record[key] for key in ("verdict", "warnings") if key in record}
    print_description({key: value for key, value in record.items() if key not in judged})
    if judged:
        print_verdict(Verdict.from_record(judged))


def print_description(record: dict[str, Any], indent: str = "") -> None:
    """Print nested records, those without anything below them on one line."""
    for key, value in record.items():
        if key == "body" and not indent:
            typer.echo("body:")
            for line in body_lines(value):
                typer.echo(f"  {line}")
        elif not isinstance(value, dict):
            typer.echo(f"{indent}{key}: {_text(value)}")
        elif indent and not any(isinstance(below, dict) for below in value.values()):
            typer.echo(f"{indent}{key}: " + ", ".join(f"{name} {_text(below)}" for name, below in value.items()))
        else:
            typer.echo(f"{indent}{key}:" + ("" if value else " none"))
            print_description(value, indent + "  ")


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
