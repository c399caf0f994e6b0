"""All pictures of a solution: one per instant, an overview, and the curves over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from toolkit.errors import InputError
from toolkit.render.probe import drawing
from toolkit.replaced_file import replaced
from toolkit.solution import Solution

_INSTANTS = 4
"""Instants that are drawn if nobody asks for others, and most that fit into the overview."""


def render_solution(
    solution: Solution, directory: str | Path, instants: Sequence[float] | None = None, width: int = 1600
) -> list[Path]:
    """Draw a solution into PNG files of a directory, which is made if it does not exist.

    Parameters
    ----------
    instants : sequence of float
        Times, in the scene's unit; each is drawn at the nearest step. By default four, evenly spread up to the end.
    width : int
        Width of every picture in pixels.

    Returns
    -------
    files : list of Path
        `step-<number>.png` per instant; `overview.png` with up to four of them; `curves.png` if there is more than one step.

    Raises
    ------
    RenderError
        There is no OpenGL here, or a package is missing; names what to install.
    InputError
        An instant lies outside the solution.
    """
    steps = chosen_steps(solution, instants)
    directory = Path(directory)
    with drawing():
        from toolkit.render.configuration import Configuration
        from toolkit.render.curves import draw_curves
        from toolkit.render.look import choose_look
        from toolkit.render.scene_picture import draw_instant, draw_overview

        directory.mkdir(parents=True, exist_ok=True)
        look, moments = choose_look(solution, steps), [Configuration(solution, step) for step in steps]
        digits = len(str(solution.steps))
        files = [
            _write(directory / f"step-{moment.step:0{digits}}.png", draw_instant, moment, look, width=width) for moment in moments
        ]
        if len(moments) > 1:
            few = [moments[k] for k in np.unique(np.linspace(0, len(moments) - 1, _INSTANTS).round().astype(int))]
            files.append(_write(directory / "overview.png", draw_overview, few, look, width=width))
        if solution.steps:
            files.append(_write(directory / "curves.png", draw_curves, solution, width=width))
    return files


def chosen_steps(solution: Solution, instants: Sequence[float] | None) -> list[int]:
    """Numbers of the steps to draw, in order, each once.

    Raises
    ------
    InputError
        An instant lies outside the solution.
    """
    if instants is None:
        return sorted({int(step) for step in np.linspace(0, solution.steps, _INSTANTS + 1).round()[1:]})
    first, last = solution.times[0], solution.times[-1]
    slack = 1e-9 * max(abs(first), abs(last))
    for instant in instants:
        if not first - slack <= instant <= last + slack:
            raise InputError(f"there is nothing to draw at t = {instant:g}: the solution runs from {first:g} to {last:g}.")
    return sorted({int(np.argmin(np.abs(solution.times - instant))) for instant in instants})


def _write(path: Path, draw: Callable[..., None], *arguments: Any, width: int) -> Path:
    """Draw under a temporary name, then rename: an interrupted run leaves the old picture or none."""
    with replaced(path) as temporary:
        draw(*arguments, temporary, width)
    return path
