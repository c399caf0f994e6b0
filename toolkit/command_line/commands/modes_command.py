"""The command `ffrf modes`: eigenfrequencies of a scene, with their damping where it is known."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

from toolkit.command_line.announcements import at_work
from toolkit.command_line.arguments import Changes, SceneFile, read
from toolkit.command_line.printing import tell
from toolkit.foundation.terminal import AsJson, Quiet
from toolkit.report.answer import Answer, AnswerTable, Record

if TYPE_CHECKING:
    from toolkit.analyses.modes import Modes


def modes(
    scene: SceneFile,
    count: Annotated[int, typer.Option(min=1, help="How many, from the lowest.")] = 10,
    about_start: Annotated[
        bool, typer.Option("--undeformed", help="About the given positions, e.g. of a free body, not the equilibrium.")
    ] = False,
    spinning: Annotated[
        bool, typer.Option("--spinning", help="About the steady state of a scene that its driver spins, in the frame that spins.")
    ] = False,
    changes: Changes = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Print the eigenfrequencies about the equilibrium under the loads at the end time, or about a steady spin."""
    from toolkit.api.model import compile_model

    described = read(scene, changes, quiet)
    with at_work("load steps", described, "static", quiet=quiet) as progress:
        found = compile_model(described).modes(count=count, undeformed=about_start, spinning=spinning, progress=progress)
    tell(ModesAnswer(found, found.verdict), as_json, quiet)


class ModesAnswer(Answer):
    """Eigenfrequencies, and damping in parts of the critical one."""

    result: Modes

    def record(self) -> Record:
        """JSON object."""
        damping = self.result.damping
        ratios = {} if damping is None else {"damping_ratios": {"value": damping.tolist(), "unit": "1"}}
        return {"frequencies": {"value": self.result.frequencies.tolist(), "unit": "Hz"}, **ratios, **self.verdict.record()}

    def tables(self) -> Iterator[AnswerTable | str]:
        """One row per mode."""
        frequencies, damping = self.result.frequencies.tolist(), self.result.damping
        ratios = [[]] * len(frequencies) if damping is None else [[f"{each:.3g}"] for each in damping]
        rows = [(k, frequency, *ratio) for k, (frequency, ratio) in enumerate(zip(frequencies, ratios, strict=True), 1)]
        yield AnswerTable(["mode", "frequency in Hz", *([] if damping is None else ["damping ratio"])], rows)
        if frequencies and frequencies[0] < 0:
            yield "A negative frequency f means an unstable equilibrium: motions grow like exp(2 pi |f| t)."
