"""The command `ffrf check-deformation`: flexible bodies solved again with elements that turn, under the same forces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from toolkit.command_line.arguments import Changes, Static, Variables, design_of, read
from toolkit.command_line.keeping import Models, SceneOrResults, is_results, motion_of, solved
from toolkit.command_line.printing import tell
from toolkit.foundation.errors import InputError
from toolkit.foundation.terminal import AsJson, Quiet
from toolkit.foundation.units import unit
from toolkit.report.answer import Answer, AnswerTable, Record

if TYPE_CHECKING:
    from pathlib import Path

    from toolkit.analyses.sensitivity.certificate.whole_mechanism import Mechanism
    from toolkit.system.solution import Solution
    from toolkit.validity.bodies.corotational_beams import Comparison


def check_deformation(
    file: SceneOrResults,
    static: Static = False,
    variables: Variables = None,
    changes: Changes = None,
    models: Models = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Solve flexible bodies again with elements that turn: alone under the same forces, and the whole mechanism with its gradients."""
    from toolkit.analyses.sensitivity.certificate.whole_mechanism import compare_mechanism
    from toolkit.foundation.verdict import Verdict
    from toolkit.validity.bodies.corotational_beams import compare_with_corotational, flexible_of

    solution = _solution(file, static, changes, models, quiet)
    scene = solution.system.scene
    names = design_of(scene, variables) if scene.design or variables else []
    whole = compare_mechanism(solution, names)
    alone = [body for body in flexible_of(solution) if body in scene.bodies]
    if whole is not None and not scene.space.turning_elements:  # the mechanism alone tells of beams in space
        alone = [body for body in alone if body not in whole.elements]
    found = {body: compare_with_corotational(solution, body) for body in alone}
    verdict = Verdict.of([*solution.verdict.warnings, *(whole.cautions() if whole else [])], solution.verdict.measures)
    tell(DeformationAnswer(found, verdict, whole, scene.units), as_json, quiet)


def _solution(file: Path, static: bool, changes: list[str] | None, models: Path | None, quiet: bool) -> Solution:
    if not static:
        return motion_of(file, changes, models, quiet)()
    if is_results(file):
        raise InputError("--static belongs to a scene; results are of the analysis that they were kept of. Leave it out.")
    return solved(read(file, changes, quiet), "static", quiet)


@dataclass(frozen=True)
class DeformationAnswer(Answer):
    """Flexible bodies alone, by their names, and the whole mechanism if it has beams, with elements that turn."""

    result: dict[str, Comparison]
    whole: Mechanism | None
    units: str

    def record(self) -> Record:
        """JSON object."""
        length, stress = unit(self.units, "length"), unit(self.units, "stress")
        checked = {
            body: {
                "time": each.estimate.time,
                "largest_rotation": {"value": each.estimate.rotation, "unit": "rad"},
                "largest_displacement": {"value": each.estimate.displacement, "unit": length},
                "estimated_error": {"value": each.estimate.error, "unit": length},
                "error": {"value": each.error, "unit": length},
                "relative_error": each.relative,
                "largest_stress": {"value": each.stress, "corotational": each.corotational_stress, "unit": stress},
                "stress_error": {"value": each.stress_error, "unit": stress},
            }
            for body, each in self.result.items()
        }
        return {"deformation": checked, "mechanism": self.whole and _mechanism_record(self.whole), **self.verdict.record()}

    def tables(self) -> Iterator[AnswerTable | str]:
        """One row per body with what is compared, then the mechanism."""
        if self.result:
            length, stress = unit(self.units, "length"), unit(self.units, "stress")
            head = [
                "body", f"displacement, {length}", f"geometric error, {length}", "of displacement", f"estimate, {length}",
                f"stress, {stress}", f"corotational, {stress}", f"largest difference, {stress}",
            ]  # fmt: skip
            yield AnswerTable(head, [
                (
                    body, each.estimate.displacement, f"{each.error:.4g}", f"{each.relative:.2%}", f"{each.estimate.error:.4g}",
                    each.stress, each.corotational_stress, f"{each.stress_error:.4g}",
                )
                for body, each in self.result.items()
            ])  # fmt: skip
        for body, each in self.result.items():
            yield (
                f"{body} at t = {each.estimate.time:g}: linear elements against corotational ones under the same forces in the body's "
                "frame (joints, loads, and inertia)."
            )
        if self.whole is not None:
            yield from _mechanism_tables(self.whole)


def _mechanism_record(found: Mechanism) -> Record:
    """Part of the JSON object about the whole mechanism."""
    record: dict[str, Any] = {"elements": found.elements, "distances": found.distances, "failure": found.failure or None}
    if found.own is None or found.corotational is None:
        return record
    own, exact, quotients = found.own, found.corotational, found.quotients
    responses = {f: {"value": value, "corotational": exact.values[f], "unit": own.units[f]} for f, value in own.values.items()}
    gradients = {
        f: {
            x: {"value": slope, "corotational": exact.gradients[f][x], "central_difference": quotients[f].get(x)}
            for x, slope in slopes.items()
        }
        for f, slopes in own.gradients.items()
    }
    return {**record, "responses": responses, "gradients": gradients}


def _mechanism_tables(found: Mechanism) -> Iterator[AnswerTable | str]:
    """Values and gradients of both mechanisms, then distances of the bodies."""
    if found.own is None or found.corotational is None:
        return
    own, exact = found.own, found.corotational
    head = ["response", "of these frames", "a frame to every element", "off by", "unit"]
    values = [(f, value, exact.values[f], _off(value, exact.values[f]), own.units[f]) for f, value in own.values.items()]
    yield AnswerTable(head, values)
    slopes = []
    for f, x, slope in ((f, x, slope) for f, row in own.gradients.items() for x, slope in row.items()):
        true = exact.gradients[f][x]
        off = "wrong sign" if slope * true < 0 else _off(slope, true)
        slopes.append((f, x, slope, true, off, found.quotients[f].get(x, "-")))
    if own.gradients:
        yield AnswerTable(["gradient", "by", *head[1:4], "its central difference"], slopes)
    for body, count in found.elements.items():
        apart = (
            f": nodes are up to {found.distances[body]:.2%} of the largest displacement from where they are with the frames of the scene"
            if body in found.distances
            else ""
        )
        frames = "1 frame" if count == 1 else f"{count} frames"
        yield f"The whole mechanism, joints in place, with {frames} in {body}, one to every element{apart}."


def _off(value: float, true: float) -> str:
    return f"{value / true - 1:.2%}" if true else "-"
