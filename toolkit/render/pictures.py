"""All pictures of a solution: one per instant, an overview, and the curves over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.replaced_file import replaced
from toolkit.render.gif import MOST_FRAMES, write_animation
from toolkit.render.probe import drawing
from toolkit.render.view import View
from toolkit.system.solution import Solution

_INSTANTS = 4
"""Instants that are drawn if nobody asks for others, and most that fit into the overview."""
_SMALL = 800
"""Width of a moving picture at most, in pixels."""
_PLAIN = View()


def render_solution(
    solution: Solution,
    directory: str | Path,
    instants: Sequence[float] | None = None,
    width: int = 1600,
    view: View = _PLAIN,
    animate: bool = False,
) -> list[Path]:
    """Draw a solution into PNG files of a directory, which is made if it does not exist.

    Parameters
    ----------
    instants : sequence of float
        Times, in the scene's unit; each is drawn at the nearest step. By default four, evenly spread up to the end.
    width : int
        Width of every picture in pixels; an animation has at most 800.
    view : View
        How a scene in space is looked at.
    animate : bool
        Whether a motion is drawn as a moving picture too.

    Returns
    -------
    files : list of Path
        `step-<number>.png` per instant; `overview.png` with up to four of them; `curves.png` and, on request, `animation.gif` if there is
        more than one step.

    Raises
    ------
    RenderError
        There is no OpenGL here, or a package is missing; names what to install.
    InputError
        An instant lies outside the solution, or a planar scene cannot be looked at like this.
    """
    view.check(solution.system.scene)
    steps = chosen_steps(solution, instants)
    directory = Path(directory)
    with drawing():
        artist = _artist(solution, view)
        directory.mkdir(parents=True, exist_ok=True)
        shown = sorted({int(k) for k in np.linspace(0, len(solution.times) - 1, MOST_FRAMES).round()}) if animate else []
        look, moments = artist.look([*steps, *shown]), [artist.moment(step) for step in steps]
        digits = len(str(solution.steps))
        files = [
            _write(directory / f"step-{moment.step:0{digits}}.png", artist.instant, moment, look, width=width)
            for moment in moments
        ]
        if len(moments) > 1:
            few = [moments[k] for k in np.unique(np.linspace(0, len(moments) - 1, _INSTANTS).round().astype(int))]
            files.append(_write(directory / "overview.png", artist.overview, few, look, width=width))
        if solution.steps:
            files.append(_write(directory / "curves.png", artist.curves, solution, width=width))
        if len(shown) > 1:
            frames = [artist.moment(step) for step in shown]
            files.append(
                _write(directory / "animation.gif", write_animation, frames, artist.instant, look, width=min(width, _SMALL))
            )
    return files


class _Artist(NamedTuple):
    """What draws a scene, in the plane or in space."""

    moment: Callable[[int], Any]
    look: Callable[[Sequence[int]], Any]
    instant: Callable[..., None]
    overview: Callable[..., None]
    curves: Callable[..., None]


def _artist(solution: Solution, view: View) -> _Artist:
    if solution.system.scene.dimension == 3:
        from toolkit.render.space.configuration import SpatialConfiguration
        from toolkit.render.space.curves import draw_spatial_curves
        from toolkit.render.space.look import choose_spatial_look
        from toolkit.render.space.scene_picture import draw_spatial_instant, draw_spatial_overview

        return _Artist(
            lambda step: SpatialConfiguration(solution, step),
            lambda steps: choose_spatial_look(solution, steps, view),
            draw_spatial_instant, draw_spatial_overview, draw_spatial_curves,
        )  # fmt: skip
    from toolkit.render.plane.configuration import Configuration
    from toolkit.render.plane.curves import draw_curves
    from toolkit.render.plane.look import choose_look
    from toolkit.render.plane.scene_picture import draw_instant, draw_overview

    return _Artist(
        lambda step: Configuration(solution, step),
        lambda steps: choose_look(solution, steps),
        draw_instant,
        draw_overview,
        draw_curves,
    )


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
