"""The command `ffrf`: simulate, differentiate, inspect and draw scenes. What takes long to import is imported by the commands."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from typer.core import TyperGroup

from toolkit.errors import InputError, ToolkitError

if TYPE_CHECKING:
    from toolkit.scene import Scene

INTERRUPTED = 130
"""Exit code of a command that Ctrl-C ended, as shells have it."""


class Commands(TyperGroup):
    """All commands: an error of the toolkit becomes one plain message and exit code 1."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was asked for."""
        try:
            return super().invoke(ctx)
        except ToolkitError as error:
            typer.echo(str(error), err=True)
            raise typer.Exit(1) from None
        except KeyboardInterrupt:
            typer.echo("interrupted.", err=True)
            raise typer.Exit(INTERRUPTED) from None


app = typer.Typer(
    cls=Commands,
    add_completion=False,
    pretty_exceptions_enable=False,
    no_args_is_help=True,
    help="Flexible multibody dynamics with exact design sensitivities.",
)


class Method(str, Enum):
    """How gradients are computed."""

    direct = "direct"
    complex_step = "complex-step"
    forward_difference = "forward-difference"
    central_difference = "central-difference"


SceneFile = Annotated[Path, typer.Argument(metavar="SCENE.toml", help="The scene.")]
Changes = Annotated[
    list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="Replace a value of the scene, e.g. points.A.x=73.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else on standard output.")]


@app.command()
def simulate(scene: SceneFile, changes: Changes = None, as_json: AsJson = False) -> None:
    """Integrate the scene over time and print its responses."""
    from toolkit.sensitivity.analysis import prepare, result, solve

    described = read(scene, changes)
    with progress_of("time steps", "transient") as progress:
        solution = solve(prepare(described), "transient", progress)
    _print_result(result(described, solution, {}, "none", solution.wall["run"], 0.0), as_json)


@app.command()
def statics(scene: SceneFile, changes: Changes = None, as_json: AsJson = False) -> None:
    """Find the equilibrium under the full load and print its responses with gradients."""
    from toolkit.sensitivity.analysis import direct

    described = read(scene, changes)
    with progress_of("load steps", "static") as progress:
        found = direct(described, list(described.design), "static", progress)
    _print_result(found, as_json)


@app.command()
def sensitivity(
    scene: SceneFile,
    method: Annotated[Method, typer.Option(help="How the gradients are computed.")] = Method.direct,
    variables: Annotated[
        str | None, typer.Option(metavar="t_w,x_A,...", help="Short names or paths; by default all that the scene declares.")
    ] = None,
    static: Annotated[bool, typer.Option("--static", help="Of the static end state instead of the motion.")] = False,
    changes: Changes = None,
    as_json: AsJson = False,
) -> None:
    """Print the responses with their gradients."""
    from toolkit.sensitivity.analysis import direct
    from toolkit.sensitivity.numerical import numerical

    described = read(scene, changes)
    names = design_of(described, variables)
    kind: Literal["static", "transient"] = "static" if static else "transient"
    with progress_of("steps" if method is Method.direct else "variables", kind) as progress:
        if method is Method.direct:
            found = direct(described, names, kind, progress)
        else:
            found = numerical(described, names, kind, method.value, progress)
    _print_result(found, as_json)


@app.command()
def modes(
    scene: SceneFile,
    count: Annotated[int, typer.Option(min=1, help="How many, from the lowest.")] = 10,
    changes: Changes = None,
    as_json: AsJson = False,
) -> None:
    """Print the eigenfrequencies about the static end state."""
    from toolkit.command_line.report import print_frequencies, print_json
    from toolkit.sensitivity.analysis import prepare, solve
    from toolkit.solvers.modes import solve_modes

    described = read(scene, changes)
    with progress_of("load steps", "static") as progress:
        frequencies = solve_modes(solve(prepare(described), "static", progress), count).frequencies.tolist()
    if as_json:
        print_json({"frequencies": {"value": frequencies, "unit": "Hz"}})
    else:
        print_frequencies(frequencies)


@app.command()
def inspect(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A reduced model, or a scene.")], as_json: AsJson = False
) -> None:
    """Print what is in a reduced model (.h5) or a scene (.toml)."""
    from toolkit.command_line.inspection import describe, print_description
    from toolkit.command_line.report import print_json

    (print_json if as_json else print_description)(describe(file))


@app.command()
def render(
    scene: SceneFile,
    output: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the pictures.")] = Path("output"),
    times: Annotated[
        list[float] | None, typer.Option("--time", help="Instant to draw; repeatable. By default four up to the end.")
    ] = None,
    width: Annotated[int, typer.Option(min=200, max=10000, help="Width of the pictures in pixels.")] = 1600,
    changes: Changes = None,
    as_json: AsJson = False,
) -> None:
    """Simulate the scene and draw it at several instants into PNG files."""
    from toolkit.command_line.report import print_json
    from toolkit.render.pictures import render_solution
    from toolkit.sensitivity.analysis import prepare, solve

    described = read(scene, changes)
    with progress_of("time steps", "transient") as progress:
        files = render_solution(solve(prepare(described), "transient", progress), output, times, width)
    if as_json:
        print_json({"files": [str(file) for file in files]})
    else:
        typer.echo("\n".join(str(file) for file in files))


def read(path: Path, changes: list[str] | None) -> Scene:
    """The scene with its changed values."""
    from toolkit.scene_file import read_scene

    pairs = dict(split(change) for change in changes or [])
    return read_scene(path, pairs)


def split(change: str) -> tuple[str, str]:
    """Path and value of `path=value`."""
    path, equals, value = (part.strip() for part in change.partition("="))
    if not (path and equals and value):
        raise typer.BadParameter(f"{change!r} is not of the form path=value, for example points.A.x=73.", param_hint="--set")
    return path, value


def design_of(scene: Scene, names: str | None) -> list[str]:
    """Names of the design variables that were asked for."""
    chosen = list(scene.design) if names is None else [name.strip() for name in names.split(",") if name.strip()]
    if not chosen:
        raise InputError(
            "no design variable: the scene declares none in its table [design]. Name some with --variables; available paths: "
            f"{', '.join(scene.available_paths())}."
        )
    return chosen


def progress_of(title: str, kind: Literal["static", "transient"]) -> Any:
    """Progress bar on standard error."""
    from toolkit.command_line.announcements import at_work

    return at_work(title, kind)


def _print_result(result: Any, as_json: bool) -> None:
    from toolkit.command_line.report import print_result

    print_result(result, as_json)


def main() -> None:
    """Run the command."""
    app()


if __name__ == "__main__":
    main()
