"""The command `ffrf`: simulate, differentiate, inspect and draw scenes. What takes long to import is imported by the commands."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from toolkit.analyses.sensitivity.method_names import GradientMethod
from toolkit.command_line.announcements import Kind, at_work
from toolkit.command_line.arguments import Changes, KeepAll, SceneFile, Static, Variables, design_of, read
from toolkit.command_line.commands.campbell_command import campbell
from toolkit.command_line.commands.certification import certify
from toolkit.command_line.commands.deformation_check import check_deformation
from toolkit.command_line.commands.export import export
from toolkit.command_line.commands.inspection import inspect
from toolkit.command_line.commands.modes_command import modes
from toolkit.command_line.commands.new_project import app as new_project
from toolkit.command_line.commands.optimize_command import optimize
from toolkit.command_line.commands.report_command import report
from toolkit.command_line.commands.stability import stability
from toolkit.command_line.commands.sweep_command import sweep
from toolkit.command_line.commands.tradeoff import tradeoff
from toolkit.command_line.commands.uncertainty_command import uncertainty
from toolkit.command_line.commands.warm_up import warm_up
from toolkit.command_line.keeping import (
    FRAMES_OF_FREE_MOTION,
    Models,
    Output,
    SceneOrResults,
    check_output,
    free_motions_of,
    keep,
    motion_of,
    refuse_contrary,
    text_of,
)
from toolkit.command_line.printing import prepare_folder, print_files, tell
from toolkit.command_line.run_answer import RunAnswer
from toolkit.foundation.processes import SINGLE
from toolkit.foundation.rare_collections import last_work
from toolkit.foundation.terminal import AsJson, Quiet, Version, errors_in_words, usage_in_json

if TYPE_CHECKING:
    from toolkit.api.model import Model
    from toolkit.scene.scene import Scene


def in_words(shown: Callable[..., None]) -> Callable[..., None]:
    """Function that shows warnings: those of the toolkit as plain sentences, others as before."""

    def show(message: Warning | str, category: type[Warning], *rest: object, **more: object) -> None:
        if category.__module__.startswith("toolkit."):
            typer.echo(f"note: {message}", err=True)
        else:
            shown(message, category, *rest, **more)

    return show


class Commands(TyperGroup):
    """Group of all commands, in which an error of the toolkit becomes one plain message and exit code 1."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments before the name of a command."""
        with usage_in_json("--json" in args):
            return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> object:
        """Run the command that was asked for."""
        as_json = "--json" in ctx.args  # the group's arguments are gone once its command runs
        with errors_in_words(as_json), usage_in_json(as_json), warnings.catch_warnings():
            warnings.showwarning = in_words(warnings.showwarning)
            return super().invoke(ctx)


app = typer.Typer(
    cls=Commands,
    pretty_exceptions_enable=False,
    no_args_is_help=True,
    help="Flexible multibody dynamics with exact design sensitivities.",
)
app.add_typer(new_project, name="new")


@app.callback()
def about(_version: Version = False) -> None:
    """Flexible multibody dynamics with exact design sensitivities."""


@app.command()
def simulate(
    scene: SceneFile,
    keep_all: KeepAll = False,
    changes: Changes = None,
    output: Output = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Integrate the scene over time and print its responses."""
    described, text = read(scene, changes, quiet), text_of(scene)
    check_output(output, described)
    with at_work("time steps", described, "transient", quiet=quiet) as progress:
        found = _compiled(described, keep_all).simulate(progress=progress, timed=True)
    keep(found, output, text, changes, quiet)
    tell(RunAnswer(found, found.verdict), as_json, quiet)


def _compiled(scene: Scene, keep_all: bool) -> Model:
    """Model of a scene with only what it needs, or with everything put back."""
    from toolkit.api.model import Model, compile_model

    if not keep_all:
        return compile_model(scene)
    from toolkit.analyses.sensitivity.chosen_frames import with_chosen_frames
    from toolkit.analyses.sensitivity.compiled import Compiled
    from toolkit.report.cost_terms import prepare_everything

    return Model(Compiled.of(prepare_everything(with_chosen_frames(scene, "transient"))))


@app.command()
def statics(
    scene: SceneFile,
    past_limit: Annotated[
        bool, typer.Option("--past-limit", help="Follow the path of equilibria past limit points (snap-through), by arc length.")
    ] = False,
    changes: Changes = None,
    output: Output = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Find the equilibrium under the loads at the end time and print its responses with gradients."""
    from toolkit.api.model import compile_model

    changes = [*(changes or []), *(["solver.continuation=arc-length"] if past_limit else [])] or None
    described, text = read(scene, changes, quiet), text_of(scene)
    check_output(output, described)
    names = list(described.design)
    with at_work("load steps", described, "static", names, quiet) as progress:
        found = compile_model(described, names).statics(gradients="direct" if names else False, progress=progress, timed=True)
    keep(found, output, text, changes, quiet)
    tell(RunAnswer(found, found.verdict), as_json, quiet)


@app.command()
def sensitivity(
    scene: SceneFile,
    method: Annotated[
        GradientMethod, typer.Option(help="How the gradients are computed; auto takes the cheaper exact method and says why.")
    ] = GradientMethod.auto,
    variables: Variables = None,
    static: Static = False,
    changes: Changes = None,
    output: Output = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Print the responses with their gradients."""
    from toolkit.api.model import compile_model

    described, text = read(scene, changes, quiet), text_of(scene)
    check_output(output, described)
    names = design_of(described, variables)
    kind: Kind = "static" if static else "transient"
    with at_work("gradients", described, kind, names, quiet, method.value) as progress:
        model = compile_model(described, names)
        found = model.run(kind, gradients=method.value, progress=progress, timed=True, keep_states=output is not None)
    tell(RunAnswer(found, found.verdict), as_json, quiet)
    keep(found, output, text, changes, quiet)


@app.command()
def render(
    file: SceneOrResults,
    output: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the pictures.")] = Path("output"),
    times: Annotated[
        list[float] | None,
        typer.Option("--time", help="Instant to draw; repeatable. By default up to four at which something happens."),
    ] = None,
    width: Annotated[int, typer.Option(min=200, max=10000, help="Width of the pictures in pixels.")] = 1600,
    kind: Annotated[str, typer.Option("--format", help="Of the pictures: png, or of planar scenes svg or pdf.")] = "png",
    animate: Annotated[bool, typer.Option("--animate", help="Draw the motion as a moving picture (GIF) too.")] = False,
    film: Annotated[bool, typer.Option("--film", help="Draw the motion as a film (MP4) too.")] = False,
    static: Annotated[
        bool, typer.Option("--static", help="Draw the equilibrium under the loads at the end, not the motion.")
    ] = False,
    free_motions: Annotated[
        bool, typer.Option("--free-motions", help="Draw what neither joints nor stiffness hold, not the motion.")
    ] = False,
    perspective: Annotated[bool, typer.Option("--perspective", help="In space: what is nearer is larger.")] = False,
    triads: Annotated[bool, typer.Option("--triads", help="In space: draw the axes of the bodies' frames.")] = False,
    changes: Changes = None,
    models: Models = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Simulate the scene, or read its results, and draw it at several instants, or its equilibrium."""
    from toolkit.analyses.statics import farthest
    from toolkit.foundation.files.safe_files import refuse_foreign
    from toolkit.render.pictures import file_names, refuse_what_cannot_be_drawn, render_solution
    from toolkit.render.readable_units import View

    refuse_contrary(static, free_motions, animate, film, times)
    view = View(perspective, triads, kind)
    solve = motion_of(file, changes, models, quiet, lambda scene: refuse_what_cannot_be_drawn(scene, view, film), static)
    if free_motions:
        frames = FRAMES_OF_FREE_MOTION if animate else 1
        solve, times = free_motions_of(file, changes, times, frames), None
    refuse_foreign(output, file_names(kind, animate, film))
    folder = prepare_folder(output)
    solution = solve()
    if free_motions:
        times = farthest(solution, frames)
    print_files(render_solution(solution, folder, times, width, view, animate, film), solution.verdict, as_json, quiet)


app.command()(campbell)
app.command()(certify)
app.command()(check_deformation)
app.command()(export)
app.command()(inspect)
app.command()(modes)
app.command()(optimize)
app.command()(report)
app.command()(stability)
app.command()(sweep)
app.command()(tradeoff)
app.command("warm-up")(warm_up)
app.command()(uncertainty)


def main() -> None:
    """Run the command, with one thread in the linear algebra if nobody asks for more.

    Matrices of scenes are small: threads that wait for each other cost a warm command two fifths of its time, and those of several
    processes more. numpy reads the variables when it is imported, which is after this.
    """
    os.environ.update({name: number for name, number in SINGLE.items() if name not in os.environ})
    with last_work():
        app()


if __name__ == "__main__":
    main()
