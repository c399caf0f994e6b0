"""`ffrf warm-up`: compile for this machine what other commands would compile when they first need it."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from toolkit.command_line.announcements import told_compilation
from toolkit.foundation.terminal import AsJson, Quiet, print_json


class WarmUpPart(StrEnum):
    """Part of the formulas that can be compiled."""

    plane = "plane"
    space = "space"
    both = "both"


def warm_up(
    part: Annotated[WarmUpPart, typer.Option("--for", help="Scenes in the plane, in space, or both.")] = WarmUpPart.both,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Compile the formulas for this machine, e.g. while an image is built, so that no later command has to."""
    from toolkit.command_line.rehearsal import rehearse_everything
    from toolkit.foundation.compiled.compiled_code import is_kept
    from toolkit.scene.space import PLANE, SPACE

    spaces = {WarmUpPart.plane: [PLANE], WarmUpPart.space: [SPACE], WarmUpPart.both: [PLANE, SPACE]}[part]
    found = {}
    for space in spaces:
        with told_compilation(space.dimension, quiet) as watch:
            rehearse_everything(space)
        found[f"{space.dimension}D"] = {"functions": watch.functions, "compile_s": watch.seconds}
    if as_json:
        print_json({"compiled": found, "kept": is_kept()})
    elif not any(each["functions"] for each in found.values()):
        typer.echo("nothing to compile: the formulas for this machine are there.")
