"""What is in a file: a reduced model, results, or a scene with every number that can be a design variable."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from toolkit.command_line.announcements import at_work
from toolkit.command_line.arguments import Changes, KeepAll, Variables, design_of, read
from toolkit.command_line.printing import print_tables, verdict_text
from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.foundation.terminal import AsJson, Quiet, print_json
from toolkit.reduced_model.told_body import body_lines
from toolkit.report.answer import Answer, AnswerTable, Record

if TYPE_CHECKING:
    from toolkit.files.results import Results
    from toolkit.foundation.verdict import Verdict
    from toolkit.scene.scene import Scene


NOT_SOLVED = "the scene is judged as it is written, and was not solved: ffrf statics and ffrf simulate judge what comes of it."
"""What nobody should take this verdict for."""


def inspect(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A reduced model, results, or a scene.")],
    variables: Variables = None,
    keep_all: KeepAll = False,
    measure: Annotated[bool, typer.Option(help="Measure the time of a step of a scene, by short runs.")] = True,
    changes: Changes = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Print what is in a reduced model (.h5), in results (.h5) or in a scene (.toml), with the summary of what the scene costs and why."""
    from toolkit.foundation.verdict import Verdict

    record, summary = (
        (describe(file), None) if file.suffix != ".toml" else _described(file, variables, keep_all, measure, changes, quiet)
    )
    judged: dict[str, Any] = {key: record[key] for key in ("verdict", "warnings") if key in record}
    answer = FileAnswer(record, Verdict.from_record(judged) if judged else Verdict(), summary)
    print_json(answer.record()) if as_json else print_tables(answer)


def _described(
    file: Path, variables: str | None, keep_all: bool, measure: bool, changes: list[str] | None, quiet: bool
) -> tuple[Record, Record]:
    """Record and cost summary of a scene."""
    from toolkit.analyses.sensitivity.chosen_frames import with_chosen_frames

    scene = with_chosen_frames(read(file, changes, quiet), "transient")
    names = list(scene.design) if variables is None else design_of(scene, variables)
    return describe_scene(scene), cost_summary_of(scene, names, keep_all, measure, quiet)


def describe(path: Path) -> Record:
    """Content of a results file, or of a reduced model (anything else), as a record.

    Raises
    ------
    InputError, ModelFileError, ResultsFileError
        The file is missing or is none of them.
    """
    from toolkit.api.describe import describe as describe_model
    from toolkit.description.results_layout import SCHEMA
    from toolkit.foundation.files.hdf5 import schema_of
    from toolkit.reduced_model.file import is_reduced_model

    if path.is_file() and schema_of(path) == SCHEMA:
        from toolkit.files.results_file import load_results

        return describe_results(load_results(path))
    if path.suffix != ".h5" and not is_reduced_model(path):
        what = "is" if path.is_file() else "is a folder," if path.is_dir() else "does not exist; it is"
        raise InputError(
            f"{str(path)!r} {what} neither a scene (.toml) nor a reduced model or results (.h5). Give the path of one of them."
        )
    return describe_model(path)


def describe_results(results: Results) -> Record:
    """Record of stored results: what was computed, of what, with which settings."""
    from toolkit.description.results_layout import SCHEMA, SCHEMA_VERSION

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
        "responses": {name: {"value": value, "unit": results.response_units[name]} for name, value in results.responses.items()},
        "method": results.method,
        "gradients": results.gradients,
        "derivatives_of_states_by": ", ".join(results.design),
        "variables": results.variables,
        "settings": {key: value for key, value in results.settings.items() if not isinstance(value, dict)},
        "run": results.run,
        **results.verdict.record(),
        "scene": {"sha256": results.scene.sha256, "changes": ", ".join(f"{k}={v}" for k, v in results.scene.changes.items())},
        "models": dict(results.scene.models),
        "writers": results.writers,
    }


def describe_scene(scene: Scene) -> Record:
    """Record of a scene: names and kinds of all parts, design variables, numbers that could be one, and questions."""
    from toolkit.analyses.sensitivity.preparation import responses_of
    from toolkit.foundation.files.safe_files import outside_files
    from toolkit.scene.resolution import loaded
    from toolkit.validity.frame_choice import frame_choices

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
        "paths": {path: scene.value_at(path) for path in scene.available_paths()},
        **_questions(scene).record(),
    }


def _questions(scene: Scene) -> Verdict:
    """Questions about a scene before it runs; of one that cannot be compiled, the reason."""
    from toolkit.foundation.verdict import Caution, Verdict
    from toolkit.system.system import compile_scene
    from toolkit.validity.scene_cautions import cautions_of_scene

    try:
        compile_scene(scene)
        return Verdict.of([*cautions_of_scene(scene), Caution("not-solved", NOT_SOLVED, doubt=False)])
    except ToolkitError as error:
        return Verdict.of([Caution("cannot-be-compiled", str(error))])


def cost_summary_of(scene: Scene, design: list[str], keep_all: bool, measured: bool, quiet: bool = False) -> Record:
    """Cost summary of a scene, or the reason why there is none: one that cannot be compiled can still be looked at."""
    from toolkit.report.cost_summary import cost_summary

    try:
        if not measured:
            return cost_summary(scene, design, keep_all, measured=False)
        with at_work("measuring", scene, "transient", design, quiet):
            return cost_summary(scene, design, keep_all)
    except ToolkitError as error:
        return {"none": str(error)}


@dataclass(frozen=True)
class FileAnswer(Answer):
    """Content of a file as nested records, with the verdict that is kept in it, and for a scene what it costs and why."""

    result: Record
    summary: Record | None = None

    def record(self) -> Record:
        """JSON object."""
        return self.result if self.summary is None else {**self.result, "cost_summary": self.summary}

    def tables(self) -> Iterator[AnswerTable | str]:
        """Content line by line, the verdict, and the cost summary."""
        yield from described({key: value for key, value in self.result.items() if key not in ("verdict", "warnings")})
        if "verdict" in self.result:
            yield verdict_text(self.verdict)
        if self.summary is not None:
            yield from _costs(self.summary)


def described(record: Record, indent: str = "") -> Iterator[str]:
    """Lines of nested records, those without anything below them on one line."""
    for key, value in record.items():
        if key == "body" and not indent:
            yield "body:"
            yield from (f"  {line}" for line in body_lines(value))
        elif not isinstance(value, dict):
            yield f"{indent}{key}: {_text(value)}"
        elif indent and not any(isinstance(below, dict) for below in value.values()):
            yield f"{indent}{key}: " + ", ".join(f"{name} {_text(below)}" for name, below in value.items())
        else:
            yield f"{indent}{key}:" + ("" if value else " none")
            yield from described(value, indent + "  ")


def _text(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _costs(found: Record) -> Iterator[AnswerTable | str]:
    """Table for every section, then the costs and the gain."""
    if "none" in found:
        yield f"no cost summary: {found['none']}"
        return
    for section, lines in found.items():
        if section not in ("cost", "meshes"):
            rows = [(line["what"], line["kept"], line["dropped"] or "", line["why"]) for line in lines]
            yield AnswerTable([section, "kept", "dropped", "why"], rows)
    counts, rows = ("coordinates", "rows", "variables", "factorization", "solution", "bytes_read"), []
    for each in found["cost"]:
        step, first = each["step_us"], found["cost"][0]["step_us"]
        rows.append(
            (
                each["what"],
                *(each[key] for key in counts),
                *([f"{step:.1f}", f"{step / first:.2f}"] if step and first else ["", ""]),
            )
        )
    yield AnswerTable(["cost", *counts[:-1], "bytes read", "us per step", "ratio"], rows)
    for file, judged in found["meshes"].items():
        yield f"{file}: estimated: {judged['told']}."
    yield from remarks(found["cost"])


def remarks(costs: list[Record]) -> list[str]:
    """Sentences on what the numbers mean, and on what dropping gains."""
    lines = [
        "factorization, solution: multiplications of one Newton iteration; bytes read: of the arrays in the files; us: processor time."
    ]
    lean, whole = costs[0], costs[-1]
    if not (lean["step_us"] and whole["step_us"]):
        return [*lines, f"The time of a step was not measured: {lean['reason']}."]
    gain = f"Everything put back takes {whole['step_us'] / lean['step_us']:.1f} times as long per step"
    read = f" and reads {whole['bytes_read'] / lean['bytes_read']:.1f} times as many bytes" if lean["bytes_read"] else ""
    return [*lines, f"{gain}{read}; the motion is the same (ffrf simulate --keep-all)."]
