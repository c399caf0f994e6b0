"""The cost summary of a scene on the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich.console import Console

from toolkit.command_line.announcements import at_work
from toolkit.command_line.printed.printing import WIDE, table
from toolkit.foundation.errors import ToolkitError

if TYPE_CHECKING:
    from toolkit.door.model import Model
    from toolkit.scene.scene import Scene


def compiled(scene: Scene, keep_all: bool) -> Model:
    """Model of a scene with only what it needs, or with everything put back."""
    from toolkit.door.model import Model, compile_model

    if not keep_all:
        return compile_model(scene)
    from toolkit.cost_summary.everything import prepare_everything
    from toolkit.sensitivity.compiled import Compiled
    from toolkit.sensitivity.frames.chosen_frames import with_chosen_frames

    return Model(Compiled.of(prepare_everything(with_chosen_frames(scene, "transient"))))


def cost_summary_of(scene: Scene, design: list[str], keep_all: bool, measured: bool, quiet: bool = False) -> dict[str, Any]:
    """Cost summary of a scene, or the reason why there is none: one that cannot be compiled can still be looked at."""
    from toolkit.cost_summary.cost_summary import cost_summary

    try:
        if not measured:
            return cost_summary(scene, design, keep_all, measured=False)
        with at_work("measuring", scene, "transient", design, quiet):
            return cost_summary(scene, design, keep_all)
    except ToolkitError as error:
        return {"none": str(error)}


def print_cost_summary(found: dict[str, Any]) -> None:
    """Print a table for every section, then the costs and the gain."""
    console = Console(width=WIDE, highlight=False)
    if "none" in found:
        console.print(f"no cost summary: {found['none']}", markup=False)
        return
    for section, lines in found.items():
        if section not in ("cost", "meshes"):
            shown = table(section, "kept", "dropped", "why")
            for line in lines:
                shown.add_row(line["what"], str(line["kept"]), str(line["dropped"] or ""), line["why"])
            console.print(shown)
    console.print(_costs(found["cost"]))
    for file, judged in found["meshes"].items():
        console.print(f"{file}: estimated: {judged['told']}.", markup=False)
    for line in remarks(found["cost"]):
        console.print(line, markup=False)


def _costs(costs: list[dict[str, Any]]) -> Any:
    columns = ("coordinates", "rows", "variables", "factorization", "solution", "bytes read", "us per step", "ratio")
    shown = table("cost", *columns)
    for each in costs:
        step, first = each["step_us"], costs[0]["step_us"]
        measured = [f"{step:.1f}", f"{step / first:.2f}"] if step and first else ["", ""]
        counted = (each[key] for key in ("coordinates", "rows", "variables", "factorization", "solution", "bytes_read"))
        shown.add_row(each["what"], *map(str, counted), *measured)
    return shown


def remarks(costs: list[dict[str, Any]]) -> list[str]:
    """Sentences on what the numbers mean, and on what dropping gains."""
    lines = [
        "factorization, solution: multiplications of one Newton iteration; bytes read: of the arrays in the files; us: processor time."
    ]
    lean, whole = costs[0], costs[-1]
    if not (lean["step_us"] and whole["step_us"]):
        return [*lines, f"The time of a step was not measured: {lean['reason']}."]
    gain = f"Everything put back takes {whole['step_us'] / lean['step_us']:.1f} times as long per step"
    read = f" and reads {whole['bytes_read'] / lean['bytes_read']:.1f} times as many bytes" if lean["bytes_read"] else ""
    return [*lines, f"{gain}{read}; the motion is the same (ffrf simulate --keep-all)."]
