"""The command `ffrf stability`: where a scene runs stably, as maps, a table and a picture."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from toolkit.command_line.announcements import at_work
from toolkit.command_line.arguments import Changes, SceneFile, Variables, design_of, read
from toolkit.command_line.printing import prepare_folder, tell
from toolkit.foundation.terminal import AsJson, Quiet
from toolkit.report.answer import Answer, AnswerTable, Record

if TYPE_CHECKING:
    from toolkit.report.drawing import Drawing
    from toolkit.studies.stability.map_result import StabilityResult

RUNS = "runs"
"""Name of the folder of all runs."""


def stability(
    scene: SceneFile,
    maps: Annotated[
        str | None,
        typer.Option(
            metavar="step,baumgarte,...",
            help="step, baumgarte, thickness, stiffness, mass, load, speed, units; by default all that the scene has.",
        ),
    ] = None,
    variables: Variables = None,
    accuracy: Annotated[float, typer.Option(min=0, help="Relative distance to the reference beyond which a run is wrong.")] = 0.1,
    energy: Annotated[float, typer.Option(min=0, help="Part of the energy that may be created.")] = 0.05,
    most_steps: Annotated[
        int | None, typer.Option(min=1, help="Cells that need more steps are not run; by default 10000, or what the scene needs.")
    ] = None,
    jobs: Annotated[int | None, typer.Option(min=1, help="Processes; by default as many as processors.")] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder for picture, JSON file and all runs; interrupted studies resume.",
        ),
    ] = None,
    changes: Changes = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Map where the scene and its gradient are stable, drift or fail, over settings of the solver and numbers of the scene."""
    from toolkit.studies.stability.cells import Limits
    from toolkit.studies.stability.study import stability as study

    if output is not None:
        from toolkit.render.packages import require

        require("matplotlib")
        prepare_folder(output, "stability.json", "stability.png", "stability.svg")
    from toolkit.analyses.sensitivity.chosen_frames import with_chosen_frames
    from toolkit.scene.resolution import resolve

    described = resolve(with_chosen_frames(read(scene, changes, quiet), "transient")).written
    names = design_of(described, variables) if variables or described.design else []
    chosen = None if maps is None else [name.strip() for name in maps.split(",") if name.strip()]
    runs = None if output is None else output / RUNS
    limits = Limits(drift=described.solver.drift_tolerance, energy=energy, accuracy=accuracy)
    with at_work("runs", described, "transient", names, quiet, "adjoint") as progress:
        found = study(described, names, chosen, limits, most_steps, jobs or os.cpu_count() or 1, progress, runs)
    tell(StabilityAnswer(found, found.verdict, scene.parent.name or scene.stem), as_json, quiet, output)


@dataclass(frozen=True)
class StabilityAnswer(Answer):
    """Maps of a scene: where motion and gradient are stable, and what happens beyond."""

    result: StabilityResult
    scene: str

    name = "stability"
    written = ""

    def record(self) -> Record:
        """JSON object of all cells."""
        from toolkit.studies.stability.map_result import record_of

        return record_of(self.result)

    def tables(self) -> Iterator[AnswerTable | str]:
        """Limits of every map, what happens beyond them, and what the names mean."""
        from toolkit.studies.stability.map_result import breakdowns, criteria, mapped_range, stable_where

        maps, best = self.result.maps, self.result.reference
        rows = [(each.map.title, mapped_range(each), stable_where(each, "run"), stable_where(each, "gradient")) for each in maps]
        yield AnswerTable(["map", "mapped", "motion stable", "gradient stable"], rows, wrap=60)
        for beyond in (each for mapped in maps for each in breakdowns(mapped)):
            of = "gradient" if beyond.of == "gradient" else "motion"
            yield f"{beyond.place}: {of} {beyond.verdict.name}, {first_sentence(beyond.verdict.reason)}"
        for name, reason in self.result.missing.items():
            yield f"No map {name!r}: {reason}."
        if best:
            yield (
                f"Reference: step {best.step:.3g}; the next coarser one differs by {100 * best.next_values:.2g} % in the responses and "
                f"{100 * best.next_slopes:.2g} % in the gradients."
            )
        yield from criteria(self.result.limits)

    def figures(self) -> Iterator[Drawing]:
        """Coloured cells."""
        from toolkit.report.stability_drawing import stability_drawing

        yield stability_drawing(self.result, self.scene)


def first_sentence(text: str) -> str:
    """First sentence of a message, without its advice."""
    return text.split(". ")[0].rstrip(".") + "."
