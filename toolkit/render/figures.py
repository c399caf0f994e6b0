"""One figure that says most about a solution: curves of a motion, a picture of an equilibrium."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from toolkit.render.packages import RenderError, require
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
    from toolkit.render.plane.curves import curves_figure
    from toolkit.render.plane.look import choose_look
    from toolkit.render.plane.scene_picture import instant_figure

    return curves_figure(solution) if solution.steps else instant_figure(Configuration(solution, 0), choose_look(solution, [0]))


def _spatial(solution: Solution) -> Figure:
    if not solution.steps:
        raise RenderError("an equilibrium in space is drawn into files: run.render(folder).")
    from toolkit.render.space.curves import spatial_curves_figure

    return spatial_curves_figure(solution)


_FIGURES: dict[object, Callable[[Solution], Figure]] = {PLANE: _planar, SPACE: _spatial}
"""Figure of a solution in the plane, and in space."""
