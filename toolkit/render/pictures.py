"""All pictures of a solution: one per instant, an overview, and the curves over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import own_set, refuse_foreign, write_whole
from toolkit.foundation.near_ties import spread
from toolkit.render.animation import ENCODED, MOST_FRAMES, drawn_frames, telling_steps
from toolkit.render.packages import RenderError, drawing, drawing_environment, require
from toolkit.render.readable_units import View, largest_stress
from toolkit.scene.scene import Scene
from toolkit.scene.space import PLANE, SPACE
from toolkit.system.solution import Solution

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def figure_of(solution: Solution) -> Figure:
    """Curves of a motion over time, or an equilibrium as a picture.

    Parameters
    ----------
    solution
        A motion or an equilibrium.

    Raises
    ------
    RenderError
        matplotlib is not installed; or it is an equilibrium in space, whose pictures are files.
    """
    require("matplotlib")
    return _FIGURES[solution.system.scene.space](solution)


def _planar(solution: Solution) -> Figure:
    from toolkit.render.plane.configuration import Configuration
    from toolkit.render.plane.look import choose_look
    from toolkit.render.plane.scene_picture import curves_figure, instant_figure

    return curves_figure(solution) if solution.steps else instant_figure(Configuration(solution, 0), choose_look(solution, [0]))


def _spatial(solution: Solution) -> Figure:
    if not solution.steps:
        raise RenderError("an equilibrium in space is drawn into files: run.render(folder).")
    from toolkit.render.space.configuration import spatial_curves_figure

    return spatial_curves_figure(solution)


_FIGURES: dict[object, Callable[[Solution], Figure]] = {PLANE: _planar, SPACE: _spatial}
"""Figure of a solution in the plane, and in space."""


INSTANTS = 4
"""Instants that are drawn if nobody asks for others, and most that fit into the overview."""
NARROWEST, WIDEST = 200, 10_000
"""Pixels of a picture."""
_PLAIN = View()


def render_solution(
    solution: Solution,
    directory: str | Path,
    instants: Sequence[float] | None = None,
    width: int = 1600,
    view: View = _PLAIN,
    animate: bool = False,
    film: bool = False,
) -> list[Path]:
    """Draw a solution into files of a directory, which is made if it does not exist.

    Parameters
    ----------
    instants : sequence of float
        Times, in the scene's unit; each is drawn at the nearest step. By default up to four at which something happens
        (`telling_steps`).
    width : int
        Width of every picture in pixels.
    view : View
        The format of the files, and how a scene in space is looked at.
    animate : bool
        Whether a motion is drawn as a moving picture (GIF) too.
    film : bool
        The same as a film (MP4).

    Returns
    -------
    files : list of Path
        `step-<number>.png` (or what the format is) per instant; `overview.png` with up to four of them; `curves.png` and, on request,
        `animation.gif` and `animation.mp4` if there is more than one step. Those of an earlier call by these names go.

    Raises
    ------
    RenderError
        A package is missing or, for a scene in space, OpenGL; names what to install.
    InputError
        An instant lies outside the solution, or the scene cannot be looked at like this; or the folder has files of such names
        that ffrf has not written.
    """
    view.check(solution.system.scene)
    _check(directory, instants, width)
    directory = Path(directory)
    require("matplotlib", *["imageio_ffmpeg"] * film)
    names = file_names(view.format, animate, film)
    refuse_foreign(directory, names)
    endings = [ending for ending, wanted in zip((".gif", ".mp4"), (animate, film), strict=True) if wanted]
    with drawing() if solution.system.scene.space.camera else nullcontext():
        artist = _ARTISTS[solution.system.scene.space](solution, view)
        steps = chosen_steps(solution, artist.points, instants)
        shown = spread(solution.steps, MOST_FRAMES) if endings else []
        look, moments = artist.look([*steps, *shown]), [artist.moment(step) for step in steps]
        digits = len(str(solution.steps))
        files = [directory / f"step-{moment.step:0{digits}}.{view.format}" for moment in moments]
        further = {"overview": len(moments) > 1, "curves": solution.steps and not solution.names}
        others = [f"{name}.{view.format}" for name, drawn in further.items() if drawn]
        films = [f"animation{ending}" for ending in endings if len(shown) > 1]
        with own_set(directory, [*(file.name for file in files), *others, *films], instead_of=names):
            for file, moment in zip(files, moments, strict=True):
                artist.instant(moment, look, None, file, width)
            if len(moments) > 1:
                few = [moments[k] for k in spread(len(moments) - 1, INSTANTS)]
                files.append(directory / f"overview.{view.format}")
                artist.overview(few, look, files[-1], width)
            if solution.steps and not solution.names:
                files.append(directory / f"curves.{view.format}")
                artist.curves(solution, files[-1], width)
            if len(shown) > 1:
                frames = drawn_frames([artist.moment(step) for step in shown], artist.instant, look, width)
                for ending in endings:
                    files.append(directory / f"animation{ending}")
                    write_whole(files[-1], ENCODED[ending](frames))
    return files


def file_names(kind: str, animate: bool, film: bool) -> list[str]:
    """Names and patterns of the files that `render_solution` writes."""
    stills = [f"{name}.{kind}" for name in ("step-*", "overview", "curves")]
    return [*stills, *["animation.gif"] * animate, *["animation.mp4"] * film]


def _check(directory: str | Path, instants: object, width: object) -> None:
    """Refuse invalid arguments of `render_solution`."""
    if isinstance(width, bool) or not isinstance(width, int) or not NARROWEST <= width <= WIDEST:
        raise InputError(f"width = {width!r}: give a whole number of pixels from {NARROWEST} to {WIDEST}.")
    if isinstance(instants, int | float):
        raise InputError(f"instants = {instants!r}: give a list of times, [{instants!r}].")
    if Path(directory).is_file():
        raise InputError(f"{str(directory)!r} is a file. Give a folder for the pictures.")


def refuse_what_cannot_be_drawn(scene: Scene, view: View, film: bool = False) -> None:
    """Refuse a scene or machine without such pictures, before the long work begins; raises as `render_solution`."""
    view.check(scene)
    require("matplotlib", *["imageio_ffmpeg"] * film)
    if scene.space.camera:
        drawing_environment()


class _Artist(NamedTuple):
    """Drawing functions for a scene in the plane or in space."""

    moment: Callable[[int], Any]
    points: Callable[[int], np.ndarray]
    look: Callable[[Sequence[int]], Any]
    instant: Callable[..., None]
    overview: Callable[..., None]
    curves: Callable[..., None]


def _page(figure: Callable[..., Figure]) -> Callable[..., None]:
    """Function that draws a figure and writes it to a path, with the given width in pixels."""
    from toolkit.render.sheet import WIDE, write_figure

    return lambda *arguments: write_figure(figure(*arguments[:-2]), arguments[-2], arguments[-1] / WIDE)


def _artist_of_space(solution: Solution, view: View) -> _Artist:
    from toolkit.render.space.configuration import SpatialConfiguration, spatial_curves_figure
    from toolkit.render.space.look import choose_spatial_look, seen_points
    from toolkit.render.space.scene_picture import draw_spatial_instant, draw_spatial_overview

    return _Artist(
        lambda step: SpatialConfiguration(solution, step),
        lambda step: seen_points(SpatialConfiguration(solution, step)),
        lambda steps: choose_spatial_look(solution, steps, view),
        draw_spatial_instant,
        draw_spatial_overview,
        _page(spatial_curves_figure),
    )


def _artist_of_the_plane(solution: Solution, _view: View) -> _Artist:
    from toolkit.render.plane.configuration import Configuration
    from toolkit.render.plane.look import choose_look, drawn_points
    from toolkit.render.plane.scene_picture import curves_figure, instants_alike, overview_figure

    return _Artist(
        lambda step: Configuration(solution, step),
        lambda step: drawn_points(Configuration(solution, step)),
        lambda steps: choose_look(solution, steps),
        _page(instants_alike()),
        _page(overview_figure),
        _page(curves_figure),
    )


_ARTISTS = {PLANE: _artist_of_the_plane, SPACE: _artist_of_space}


def chosen_steps(solution: Solution, points: Callable[[int], np.ndarray], instants: Sequence[float] | None) -> list[int]:
    """Numbers of the steps to draw, in order, each once; `points` are what is drawn at a step.

    Raises
    ------
    InputError
        An instant lies outside the solution.
    """
    if instants is None:
        return telling_steps(INSTANTS, points, largest_stress(solution))
    first, last = solution.times[0], solution.times[-1]
    slack = 1e-9 * max(abs(first), abs(last))
    for instant in instants:
        if not first - slack <= instant <= last + slack:
            raise InputError(f"there is nothing to draw at t = {instant:g}: the solution runs from {first:g} to {last:g}.")
    return sorted({int(np.argmin(np.abs(solution.times - instant))) for instant in instants})
