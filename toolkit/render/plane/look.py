"""What all pictures of one solution share, so that they can be compared: the colours' limits, the window, the detail."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from toolkit.foundation.near_ties import spread
from toolkit.foundation.units import unit
from toolkit.render.plane.configuration import Configuration, drawn_model, skin_shape, solid_shape
from toolkit.render.readable_units import round_off, round_up, tick_step, told
from toolkit.render.sheet import settle
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution

Windows = dict[Axes, np.ndarray]
"""Axes -> corners (2, 2), lower left and upper right, of what they have to show."""
_MARGIN = 0.14
"""Round what is shown, relative to half of its extent: room for names of joints and for the thickness of bands."""
_LEAST = np.array([0.5, 0.2])
"""Width and height at least, relative to the larger of both: room for a title, and for names above and below a line."""
_TICKS = 0.45
"""Distance of ticks at least, in inches: room for the number of each."""
_BESIDE = 0.3
"""Distance of ticks along x from the sides at least, in steps of ticks."""
_THINNEST = 0.016
"""Thickness at which the two colours of a band can be told apart, relative to the window."""


def window(points: np.ndarray) -> np.ndarray:
    """Corners (2, 2), lower left and upper right, of a window that shows points (n, 2) with a margin."""
    low, high = points.min(axis=0), points.max(axis=0)
    half, middle = (high - low) / 2, (high + low) / 2
    extent = float(half.max()) or 1.0
    half = np.maximum(half, _LEAST * extent) + _MARGIN * extent
    return np.array([middle - half, middle + half])


def aspect(corners: np.ndarray) -> float:
    """Width of a window over its height."""
    wide, high = corners[1] - corners[0]
    return float(wide / high)


def panel_height(corners: np.ndarray, width: float) -> float:
    """Height in inches at which a panel in a column of that width, with labels on its left, has one scale for x and y."""
    return min((width - 0.9) / aspect(corners), 1.3 * width)


def open_windows(figure: Figure, moment: Configuration, windows: Windows, columns: int = 0, like: Figure | None = None) -> None:
    """Show windows with x and y to one scale, and lay the figure out for good; a window grows where its panel has room.

    With `columns` all windows are the same, so many beside each other, and only the lower and the left ones have numbers. What is laid out
    `like` another figure has its axes in the same places.
    """
    length = unit(moment.scene.units, "length")
    for k, (axes, corners) in enumerate(windows.items()):
        lowest, leftmost = not columns or k + columns >= len(windows), not columns or k % columns == 0
        axes.set(xlim=corners[:, 0], ylim=corners[:, 1], xlabel=f"x in {length}" * lowest, ylabel=f"y in {length}" * leftmost)
        axes.tick_params(labelbottom=lowest, labelleft=leftmost)
        axes.set_axisbelow(True)
    settle(figure, lambda: _fit(windows), like)


def _fit(windows: Windows) -> None:
    for axes, corners in windows.items():
        size, room = np.ptp(corners, axis=0), axes.bbox.size
        half = room * (size / room).max() / 2
        (left, low), (right, high) = corners.mean(axis=0) - half, corners.mean(axis=0) + half
        axes.set(xlim=(left, right), ylim=(low, high))
        step = tick_step(_TICKS * figure_of(axes).dpi * 2 * half[0] / room[0])
        room_of_number = step * np.array([_BESIDE, 0.0])  # the number of a tick at the side would run into that of the next panel
        ends = shown(axes) + np.array([[1], [-1]]) * room_of_number
        for axis, low, high in zip((axes.xaxis, axes.yaxis), *ends / step, strict=True):
            ticks = step * (np.arange(np.ceil(low), np.floor(high) + 1) + 0.0)  # no -0.0
            axis.set_major_locator(FixedLocator(ticks.tolist()))


def figure_of(axes: Axes) -> Figure:
    """Figure that axes are on."""
    found = axes.figure
    return found if isinstance(found, Figure) else found.figure  # Not get_figure(root=True), which matplotlib 3.9 lacks.


def shown(axes: Axes) -> np.ndarray:
    """Corners (2, 2) of the window that axes show."""
    return np.transpose([axes.get_xlim(), axes.get_ylim()])


def drawn_thickness(true: float, corners: np.ndarray) -> float:
    """Thickness of a skin in a window, or more if its two colours could not be told apart."""
    return max(true, _THINNEST * float(np.ptp(corners, axis=0).max()))


MOST_MOMENTS = 60
"""Number of moments of the whole motion that are looked at for what the main window has to contain."""
_DETAIL = 0.16
"""Half width of the detail, relative to the extent of the skin."""


@dataclass(frozen=True)
class Look:
    """Choices for a set of pictures.

    Attributes
    ----------
    thickness
        Flexible body that can be drawn -> its thickness, zero if unknown.
    stress_limit
        The colours run from minus to plus this stress; zero if there is no stress to show.
    points
        What the main window contains, (n, 2).
    detail
        Corners of the detail, (2, 2), or None.
    solids
        Meshed bodies that can be drawn.
    left
        Flexible bodies that leave their undeformed line by so much that it is not in what is drawn of them.
    """

    thickness: dict[str, float]
    stress_limit: float
    points: np.ndarray
    detail: np.ndarray | None
    solids: tuple[str, ...] = ()
    left: tuple[str, ...] = ()

    @property
    def extent(self) -> float:
        """Size of the drawing, which decides the digits that are shown."""
        return float(np.ptp(self.points, axis=0).max()) or 1.0

    @property
    def colors(self) -> Normalize:
        """Colour scale for the stress."""
        limit = self.stress_limit or 1.0
        return Normalize(-limit, limit)


def choose_look(solution: Solution, steps: Sequence[int]) -> Look:
    """Look of the pictures at the given steps, wide enough for the whole motion."""
    scene, first = solution.system.scene, Configuration(solution, 0)
    skins = [name for name in first.flexible() if skin_shape(first, name)]
    solids = [name for name in first.flexible() if solid_shape(first, name)]
    drawn, points, limit = {0, *steps}, [], 0.0
    for step in sorted({*spread(solution.steps, MOST_MOMENTS), *drawn}):
        moment = Configuration(solution, step)
        points.append(drawn_points(moment))
        if step in drawn:
            limit = max(limit, *(told(stress, round_off(scene, name)) for name, stress in shown_stress(moment)), 0.0)
    every = np.vstack(points)
    every = every if len(every) else np.zeros((1, 2))
    moments = [Configuration(solution, step) for step in sorted(drawn)]
    thickness = {name: _thickness(scene, name) for name in skins}
    return Look(
        thickness,
        round_up(limit),
        every,
        _detail(moments, skins),
        tuple(solids),
        tuple(
            name
            for name in skins
            if any(_leaves(each, name, drawn_thickness(thickness[name], window(every))) for each in moments)
        ),
    )


def shown_stress(moment: Configuration) -> Iterator[tuple[str, np.ndarray]]:
    """Name and displayed stress of every flexible body that can be drawn."""
    for name in moment.flexible():
        if (skin := skin_shape(moment, name)) is not None:
            yield name, skin.stress
        elif (solid := solid_shape(moment, name)) is not None:
            yield name, solid.shown


def drawn_points(moment: Configuration) -> np.ndarray:
    """Positions (n, 2) of bodies, joints and links at one moment."""
    shapes = [shape.line.reshape(-1, 2) for name in moment.flexible() if (shape := skin_shape(moment, name))]
    joints = [moment.ends(each) for each in [*moment.scene.joints.values(), *moment.links()]]
    return np.vstack([np.zeros((0, 2)), *shapes, *moment.rods(), *moment.wheels(), *joints])


def _thickness(scene: ResolvedScene, body: str) -> float:
    """Thickness of a skin or of all sections of a frame; zero where they differ."""
    path = f"bodies.{body}.thickness"
    found = {
        float(np.real(scene.number(each))) for each in scene.available_paths() if each == path or each.startswith(f"{path}_")
    }
    return found.pop() if len(found) == 1 else 0.0


def _leaves(moment: Configuration, body: str, thickness: float) -> bool:
    """Whether the middle line of a body leaves the band of the drawn thickness around the undeformed line in its place."""
    mesh, shape = drawn_model(moment, body).mesh, skin_shape(moment, body)
    if mesh is None or shape is None or len(mesh.outline) < 2:
        return False
    line = moment.place(body, mesh.outline)
    start, along = line[:-1], np.diff(line, axis=0)
    points = shape.line.reshape(-1, 1, 2)
    ratio = np.sum((points - start) * along, axis=2) / np.maximum(np.sum(along**2, axis=1), np.finfo(float).tiny)
    nearest = start + ratio.clip(0, 1)[:, :, None] * along
    return bool(np.linalg.norm(points - nearest, axis=2).min(axis=1).max() > thickness / 2)


def _detail(moments: list[Configuration], skins: list[str]) -> np.ndarray | None:
    """Corners of a square around the place where a body with a target moves most; None if nothing has a target or moves."""
    for name in skins:
        shape = drawn_model(moments[0], name).shape
        if shape is None or moments[0].scene.body(name).has_frame:
            continue
        moved = np.array([shape.position @ np.append(1.0, moment.elastic(name)) for moment in moments])
        distance = np.linalg.norm(moved - shape.position[:, :, 0], axis=2)
        step, node = np.unravel_index(np.argmax(distance), distance.shape)
        if distance[step, node] > 0:
            half = _DETAIL * np.ptp(moved[0], axis=0).max()
            centre = moments[0].place(name, (moved[step, node] + shape.position[node, :, 0])[None] / 2)[0]
            return np.array([centre - half, centre + half])
    return None
