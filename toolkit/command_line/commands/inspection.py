"""What is in a file: a reduced model, results, or a scene with every number that can be a design variable."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from toolkit.foundation.errors import InputError, ToolkitError

if TYPE_CHECKING:
    from toolkit.foundation.verdict import Verdict
    from toolkit.reduced_model.model import InterfacePoint, ReducedModel
    from toolkit.results.results import Results
    from toolkit.scene.scene import Scene


PLAIN = "plain HDF5 of another program: no checksum tells whether a bit of it was flipped"
NOT_SOLVED = "the scene is judged as it is written, and was not solved: ffrf statics and ffrf simulate judge what comes of it."
"""What nobody should take this verdict for."""


def describe(path: Path) -> dict[str, Any]:
    """Content of results, or of a reduced model (anything else).

    Raises
    ------
    InputError, ModelFileError, ResultsFileError
        The file is missing or is none of them.
    """
    from toolkit.foundation.files.hdf5 import schema_of
    from toolkit.kept_run.layout import SCHEMA
    from toolkit.reduced_model.file import is_reduced_model, load

    if path.is_file() and schema_of(path) == SCHEMA:
        from toolkit.results.results_file import load_results

        return describe_results(load_results(path))
    if path.suffix != ".h5" and not is_reduced_model(path):
        what = "is" if path.is_file() else "is a folder," if path.is_dir() else "does not exist; it is"
        raise InputError(
            f"{str(path)!r} {what} neither a scene (.toml) nor a reduced model or results (.h5). Give the path of one of them."
        )
    return describe_model(load(path))


def describe_model(model: ReducedModel) -> dict[str, Any]:
    """Everything that a reader of the file wants to know before using it."""
    from toolkit.foundation.units import unit
    from toolkit.reduced_model.file import SCHEMA, SCHEMA_VERSION
    from toolkit.reduced_model.questions.face_questions import face_record
    from toolkit.reduced_model.questions.mesh_questions import mesh_record

    length, judged, faces = unit(model.units, "length"), mesh_record(model), face_record(model)
    return {
        "schema": f"{SCHEMA}, version {SCHEMA_VERSION}",
        **({"form": PLAIN} if model.plain else {}),
        "units": model.units,
        "dimension": model.dimension,
        "reference_condition": model.reference_condition,
        "basis": model.basis,
        "parameters": {name: {"value": value, "unit": model.nominal_units[name]} for name, value in model.nominal.items()},
        "sizes": sizes(model),
        "interfaces": {name: describe_interface(point, length) for name, point in (model.interfaces or {}).items()},
        "exact_for_every_value": dependences(model, model.affine),
        "derivatives": dependences(model, model.derivatives),
        **({"stress_error": judged} if judged else {}),
        **({"face_error": faces} if faces else {}),
        "writers": dict(model.writers),
        "input_hash": model.input_hash,
    }


def dependences(model: ReducedModel, items: Mapping[str, Any] | None) -> dict[str, str]:
    """Parameter -> the arrays that depend on it, by polynomials or by derivatives."""
    found = {
        parameter: ", ".join(item for item, dependence in (items or {}).items() if dependence.depends_on(k))
        for k, parameter in enumerate(model.parameters)
    }
    return {parameter: names for parameter, names in found.items() if names}


def describe_results(results: Results) -> dict[str, Any]:
    """What was computed, of what, with which settings."""
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


def sizes(model: ReducedModel) -> dict[str, int]:
    """Numbers of coordinates, points and elements."""
    found = {"elastic coordinates": model.n_f, "stress points": len(model.invariants.stress_operator)}
    if model.shape is not None:
        found["points with a target"] = len(model.shape.target)
    if model.mesh is not None:
        found |= {"nodes": len(model.mesh.nodes), "elements": len(model.mesh.connectivity)}
    if model.pieces is not None and model.elements is not None:
        found["pieces"] = len(model.elements.connectivity)
    if model.surface is not None:
        parts = {"triangles": len(model.surface.triangles), "lines": len(model.surface.lines)}
        found |= {f"{what} of the surface": count for what, count in parts.items() if count}
    if model.surface_loads:
        found["surfaces for pressure"] = len(model.surface_loads)
    return found


def describe_interface(point: InterfacePoint, length: str) -> dict[str, Any]:
    """Where an interface point is and how far it may be moved."""
    low, high = (float(end) for end in point.arc_length_range)
    movable = f"from {low:.6g} to {high:.6g}" if low < high else "no: at a node, no derivative by the arc length"
    return {"arc_length": float(point.arc_length), "unit": length, "movable": movable}


def describe_scene(scene: Scene) -> dict[str, Any]:
    """Names and kinds of all parts, the declared design variables, all numbers that could be one, and what makes one ask."""
    from toolkit.foundation.files.outside_files import outside_files
    from toolkit.scene.cut_scene import written
    from toolkit.sensitivity.preparation import responses_of
    from toolkit.validity.description.frame_choice import frame_choices

    try:
        frames = {body: choice.words for body, choice in frame_choices(scene).items()}
    except ToolkitError:  # which is said below
        frames = {}
    outside = outside_files(scene.directory / "scene", scene.read_files())
    groups: dict[str, Mapping[str, Any]] = {"bodies": written(scene).bodies, "joints": scene.joints, "loads": scene.loads}
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
    """What is to be asked about a scene before it runs; of one that cannot be compiled, why not."""
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
        if not isinstance(value, dict):
            typer.echo(f"{indent}{key}: {_text(value)}")
        elif indent and not any(isinstance(below, dict) for below in value.values()):
            typer.echo(f"{indent}{key}: " + ", ".join(f"{name} {_text(below)}" for name, below in value.items()))
        else:
            typer.echo(f"{indent}{key}:" + ("" if value else " none"))
            print_description(value, indent + "  ")


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
