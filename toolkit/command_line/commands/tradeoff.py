"""The command `ffrf tradeoff`: what accuracy costs in a scene, and the cheapest setting that keeps a budget."""

from __future__ import annotations

import json
import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from toolkit.command_line.announcements import bar, compile_before
from toolkit.command_line.arguments import Changes, SceneFile, Variables, design_of, read, split
from toolkit.command_line.output_folder import prepare_folder
from toolkit.command_line.pictures import save_drawing
from toolkit.command_line.printed.printing import print_answer
from toolkit.command_line.printed.tradeoff_tables import print_tradeoff, record_of
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.terminal import AsJson, Quiet, answered

if TYPE_CHECKING:
    from toolkit.foundation.verdict import Verdict
    from toolkit.report.drawing import Drawing
    from toolkit.scene.scene import Scene
    from toolkit.studies.tradeoff.tradeoff import Tradeoff

Budgets = Annotated[
    list[str] | None,
    typer.Option(
        "--budget",
        metavar="RESPONSE=1e-3",
        help="Largest relative error of a response, or of its gradient by d(RESPONSE)=1e-2; repeatable. all=1e-3 by default.",
    ),
]
GradientBudgets = Annotated[
    list[str] | None,
    typer.Option(metavar="RESPONSE=1e-2", help="Of gradients; by default ten times the budget of the response."),
]
Axes = Annotated[
    str | None,
    typer.Option(
        metavar="step,scheme,...",
        help="What to vary, with values if you like: step=0.1/0.05,scheme,rho_inf=0.5/1,modes=full/8,elements,frames=1/4/every. An "
        "unknown one lists all.",
    ),
]


def tradeoff(
    scene: SceneFile,
    budget: Budgets = None,
    gradient_budget: GradientBudgets = None,
    axes: Axes = None,
    variables: Variables = None,
    gradients: Annotated[bool, typer.Option(help="Whether gradients are measured too, and part of the price.")] = True,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder of the picture, the JSON file and all that is kept.")
    ] = Path("tradeoff"),
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Processes that compute values; times are always measured one after another.")
    ] = None,
    repeats: Annotated[int, typer.Option(min=1, help="Runs whose median is a time.")] = 5,
    changes: Changes = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Measure what accuracy costs: run a grid of settings against a reference, and recommend the cheapest within a budget."""
    from toolkit.studies.tradeoff import tradeoff as study
    from toolkit.studies.tradeoff.frame_axes import framed
    from toolkit.studies.tradeoff.setting import EVERY_ELEMENT

    described = read(scene, changes, quiet)
    names = (design_of(described, variables) if described.design or variables else []) if gradients else []
    pairs = dict(split(change) for change in changes or [])
    planned = study.plan(scene, output, pairs, names, axes, budget or [], gradient_budget or [])
    folder = prepare_folder(output, "tradeoff.json", "tradeoff.png", "tradeoff.svg")
    for formulation in sorted({each.solver.get("formulation") or described.solver.formulation for each in planned.settings}):
        solver = described.solver.model_copy(
            update={"formulation": formulation}
        )  # compiled once, before several processes would do it
        compile_before(described.model_copy(update={"solver": solver}), "transient", bool(names), quiet)
    found = study.tradeoff(planned, partial(bar, quiet=quiet), jobs or os.cpu_count() or 1, repeats)
    verdict = _model_verdict(framed(described, EVERY_ELEMENT) if "frames" in planned.axes else described)
    record = {**record_of(found), **verdict.record()}
    _keep(found, record, folder, quiet)
    print_answer(lambda: record, lambda: print_tradeoff(found), verdict, as_json, quiet)
    with answered():
        found.check()


def _model_verdict(scene: Scene) -> Verdict:
    """Doubts about the model itself, which no setting fixes, from the motion with the scene's own settings."""
    from toolkit.foundation.verdict import Caution, Verdict
    from toolkit.sensitivity.preparation import prepare, solve
    from toolkit.validity.bodies.bent_surfaces import bent_surfaces
    from toolkit.validity.bodies.physics import excessive_speeds, large_deformations

    try:
        solution = solve(prepare(scene), "transient")
    except ToolkitError as error:
        return Verdict((Caution("no-own-run", f"the scene does not run with its own settings: {error}", doubt=False),))
    return Verdict.of([*large_deformations(solution), *bent_surfaces(solution), *excessive_speeds(solution)])


def _keep(found: Tradeoff, record: dict[str, Any], folder: Path, quiet: bool) -> None:
    """Write the JSON file, and the picture where it can be drawn."""
    from toolkit.foundation.files.replaced_file import write_whole

    write_whole(folder / "tradeoff.json", json.dumps(record, indent=1, allow_nan=False).encode())
    files = [folder / "tradeoff.json", *_draw(found, folder, quiet)]
    if not quiet:
        typer.echo(f"{', '.join(map(str, files))} are written.", err=True)


def _draw(found: Tradeoff, folder: Path, quiet: bool) -> list[Path]:
    return [] if len(found.failed) == len(found.settings) else save_drawing(lambda: _drawing(found), folder, quiet)


def _drawing(found: Tradeoff) -> Drawing:
    from toolkit.report.work_precision import work_precision

    return work_precision(found)
