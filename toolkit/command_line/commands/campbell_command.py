"""The command `ffrf campbell`: frequencies of a scene over the speed of its spin, as a table, as files and as a picture."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from toolkit.command_line.announcements import at_work
from toolkit.command_line.arguments import Changes, SceneFile, read
from toolkit.command_line.printing import prepare_folder, tell
from toolkit.foundation.errors import InputError
from toolkit.foundation.terminal import AsJson, Quiet
from toolkit.report.answer import Answer, AnswerTable, Record

if TYPE_CHECKING:
    from toolkit.analyses.modes import Campbell
    from toolkit.report.drawing import Drawing


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
    from toolkit.api.model import compile_model

    wanted = speeds_of(speeds)
    if output is not None:
        from toolkit.render.packages import require

        require("matplotlib")
        prepare_folder(output, "campbell.csv", "campbell.json", "campbell.png", "campbell.svg")
    described = read(scene, changes, quiet)
    with at_work("speeds", described, "static", quiet=quiet) as progress:
        found = compile_model(described).campbell(wanted, count=count, progress=progress)
    tell(CampbellAnswer(found, found.verdict, scene.parent.name or scene.stem), as_json, quiet, output)


def speeds_of(text: str) -> list[float]:
    """Speeds from the text `first:last:count`, or from a list with commas.

    Raises
    ------
    InputError
        There are more than a diagram has.
    """
    from toolkit.analyses.modes import refuse_too_many

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


@dataclass(frozen=True)
class CampbellAnswer(Answer):
    """Campbell's diagram: frequencies and damping at every speed."""

    result: Campbell
    scene: str

    name = "campbell"
    written = ""

    def record(self) -> Record:
        """JSON object of the diagram."""
        found = self.result
        return {
            "speeds": {"value": found.speeds.tolist(), "unit": "rad/s"},
            "frequencies": {"value": found.frequencies.tolist(), "unit": "Hz"},
            "damping_ratios": {"value": found.damping.tolist(), "unit": "1"},
            **self.verdict.record(),
        }

    def tables(self) -> Iterator[AnswerTable | str]:
        """Frequencies, one row per speed; with all damping ratios as a file."""
        found, modes = self.result, range(1, self.result.frequencies.shape[1] + 1)
        rows = list(zip(found.speeds.tolist(), found.frequencies.tolist(), found.damping.tolist(), strict=True))
        heads = ["speed in rad/s", *(f"frequency {k} in Hz" for k in modes), *(f"damping ratio {k}" for k in modes)]
        yield AnswerTable(heads, [(speed, *f, *d) for speed, f, d in rows], "campbell")
        least = [min((each for each in d if math.isfinite(each)), default=None) for *_, d in rows]
        shown = [(speed, *f, "" if low is None else f"{low:.3g}") for (speed, f, _), low in zip(rows, least, strict=True)]
        yield AnswerTable(["speed in rad/s", *(f"{k}, Hz" for k in modes), "least damping ratio"], shown)
        yield "Frequencies are those that the frame sees which spins with the scene, in their order at every speed."
        if (found.frequencies < 0).any():
            yield "A negative frequency f means an unstable spin: motions grow like exp(2 pi |f| t)."

    def figures(self) -> Iterator[Drawing]:
        """Frequencies over the speed."""
        from toolkit.report.drawing import campbell_drawing

        yield campbell_drawing(self.result, self.scene)
