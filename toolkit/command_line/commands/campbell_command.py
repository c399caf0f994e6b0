"""The command `ffrf campbell`: frequencies of a scene over the speed of its spin, as a table, as files and as a picture."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from toolkit.command_line.announcements import at_work
from toolkit.command_line.arguments import Changes, SceneFile, read
from toolkit.command_line.output_folder import prepare_folder
from toolkit.command_line.printed.printing import WIDE, finite_or_none, print_answer, table
from toolkit.foundation.errors import InputError
from toolkit.foundation.terminal import AsJson, Quiet

if TYPE_CHECKING:
    from toolkit.analyses.campbell import Campbell


def campbell(
    scene: SceneFile,
    speeds: Annotated[
        str, typer.Option(metavar="FIRST:LAST:COUNT", help="Speeds in rad/s, for example 0:60:13; or a list, 10,20,50.")
    ],
    count: Annotated[int, typer.Option(min=1, help="How many frequencies, from the lowest.")] = 6,
    output: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for campbell.png, campbell.svg, campbell.csv and campbell.json.")
    ] = None,
    changes: Changes = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Print the frequencies about the steady states of a scene that a driver spins, at several speeds (Campbell's diagram)."""
    from toolkit.door.model import compile_model

    wanted = speeds_of(speeds)
    if output is not None:
        from toolkit.render.packages import require

        require("matplotlib")
        prepare_folder(output, "campbell.csv", "campbell.json", "campbell.png", "campbell.svg")
    described = read(scene, changes, quiet)
    with at_work("speeds", described, "static", quiet=quiet) as progress:
        found = compile_model(described).campbell(wanted, count=count, progress=progress)
    print_answer(lambda: record_of(found), lambda: print_campbell(found), found.verdict, as_json, quiet)
    if output is not None:
        for file in write(found, output, scene.parent.name or scene.stem):
            typer.echo(str(file), err=as_json)


def speeds_of(text: str) -> list[float]:
    """Speeds from the text `first:last:count`, or from a list with commas.

    Raises
    ------
    InputError
        There are more than a diagram has.
    """
    from toolkit.analyses.campbell import refuse_too_many

    try:
        if ":" in text:
            first, last, count = text.split(":")
            low, high, n = float(first), float(last), int(count)
            if n < 2:
                raise ValueError
            refuse_too_many(n)
            return [low + (high - low) * k / (n - 1) for k in range(n)]
        return [float(each) for each in text.split(",")]
    except InputError:
        raise
    except ValueError as error:
        message = (
            f"{text!r} names no speeds: write first:last:count with a count of at least 2, for example 0:100:21, or 10,20,50."
        )
        raise typer.BadParameter(message, param_hint="--speeds") from error


def print_campbell(found: Campbell) -> None:
    """Print the frequencies, one row per speed."""
    modes = found.frequencies.shape[1]
    rows = table("speed in rad/s", *(f"{k + 1}, Hz" for k in range(modes)), "least damping ratio")
    for speed, frequencies, damping in zip(found.speeds, found.frequencies, found.damping, strict=True):
        known = [each for each in damping if math.isfinite(each)]
        rows.add_row(f"{speed:.6g}", *(f"{each:.6g}" for each in frequencies), f"{min(known):.3g}" if known else "")
    console = Console(width=WIDE, highlight=False)
    console.print(rows)
    console.print("Frequencies are those that the frame sees which spins with the scene, in their order at every speed.")
    if (found.frequencies < 0).any():
        console.print("A negative frequency f means an unstable spin: motions grow like exp(2 pi |f| t).")


def record_of(found: Campbell) -> dict[str, Any]:
    """JSON object of Campbell's diagram."""
    return {
        "speeds": {"value": found.speeds.tolist(), "unit": "rad/s"},
        "frequencies": {"value": [[finite_or_none(each) for each in row] for row in found.frequencies.tolist()], "unit": "Hz"},
        "damping_ratios": {"value": [[finite_or_none(each) for each in row] for row in found.damping.tolist()], "unit": "1"},
        **found.verdict.record(),
    }


def write(found: Campbell, folder: Path, name: str) -> list[Path]:
    """Write the picture as PNG and SVG, the table as CSV, and everything as JSON."""
    from toolkit.foundation.files.replaced_file import write_whole
    from toolkit.report.campbell_drawing import campbell_drawing
    from toolkit.results.csv_tables import write_csv

    files = campbell_drawing(found, name).save(folder)
    modes = range(1, found.frequencies.shape[1] + 1)
    heads = ["speed in rad/s", *(f"frequency {k} in Hz" for k in modes), *(f"damping ratio {k}" for k in modes)]
    rows = [
        [speed, *f, *d]
        for speed, f, d in zip(found.speeds.tolist(), found.frequencies.tolist(), found.damping.tolist(), strict=True)
    ]
    files.append(write_csv(folder / "campbell.csv", heads, rows))
    path = folder / "campbell.json"
    write_whole(path, (json.dumps(record_of(found), indent=2, allow_nan=False) + "\n").encode())
    return [*files, path]
