"""The command `ffrf stability`: where a scene runs stably, as maps, a table and a picture."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from toolkit.command_line.announcements import at_work
from toolkit.command_line.arguments import Changes, SceneFile, Variables, design_of, read
from toolkit.command_line.output_folder import prepare_folder
from toolkit.command_line.printed.printing import WIDE, print_answer, table
from toolkit.foundation.terminal import AsJson, Quiet

if TYPE_CHECKING:
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
    from toolkit.studies.stability.classifier import Limits
    from toolkit.studies.stability.record import record_of
    from toolkit.studies.stability.study import stability as study

    if output is not None:
        from toolkit.render.packages import require

        require("matplotlib")
        prepare_folder(output, "stability.json", "stability.png", "stability.svg")
    from toolkit.scene.resolution import resolve
    from toolkit.sensitivity.frames.chosen_frames import with_chosen_frames

    described = resolve(with_chosen_frames(read(scene, changes, quiet), "transient")).written
    names = design_of(described, variables) if variables or described.design else []
    chosen = None if maps is None else [name.strip() for name in maps.split(",") if name.strip()]
    runs = None if output is None else output / RUNS
    limits = Limits(drift=described.solver.drift_tolerance, energy=energy, accuracy=accuracy)
    with at_work("runs", described, "transient", names, quiet, "adjoint") as progress:
        found = study(described, names, chosen, limits, most_steps, jobs or os.cpu_count() or 1, progress, runs)
    print_answer(lambda: record_of(found), lambda: print_study(found), found.verdict, as_json, quiet)
    if output is not None:
        for file in write(found, output, scene.parent.name or scene.stem):
            typer.echo(str(file), err=as_json)


def print_study(study: StabilityResult) -> None:
    """Print the limits of every map, what happens beyond them, and what the names mean."""
    from toolkit.studies.stability.map_limits import breakdowns, mapped_range, stable_where
    from toolkit.studies.stability.record import criteria

    console = Console(width=WIDE, highlight=False)
    found = table("map", "mapped", "motion stable", "gradient stable")
    for column in found.columns:
        column.justify = "left"
        column.max_width = 60
    for each in study.maps:
        found.add_row(each.map.title, mapped_range(each), stable_where(each, "run"), stable_where(each, "gradient"))
    console.print(found)
    for each in study.maps:
        for beyond in breakdowns(each):
            of = "gradient" if beyond.of == "gradient" else "motion"
            console.print(f"{beyond.place}: {of} {beyond.verdict.name}, {first_sentence(beyond.verdict.reason)}", markup=False)
    for name, reason in study.missing.items():
        console.print(f"No map {name!r}: {reason}.", markup=False)
    if study.reference:
        console.print(
            f"Reference: step {study.reference.step:.3g}; the next coarser one differs by {100 * study.reference.next_values:.2g} % in "
            f"the responses and {100 * study.reference.next_slopes:.2g} % in the gradients.",
            markup=False,
        )
    for line in criteria(study.limits):
        console.print(line, markup=False)


def first_sentence(text: str) -> str:
    """First sentence of a message, without its advice."""
    return text.split(". ")[0].rstrip(".") + "."


def write(study: StabilityResult, folder: Path, name: str) -> list[Path]:
    """Write the picture as PNG and SVG, and everything as JSON."""
    from toolkit.foundation.files.replaced_file import write_whole
    from toolkit.report.stability_drawing import stability_drawing
    from toolkit.studies.stability.record import record_of

    files = stability_drawing(study, name).save(folder)
    path = folder / "stability.json"
    write_whole(path, (json.dumps(record_of(study), indent=2, allow_nan=False) + "\n").encode())
    return [*files, path]
