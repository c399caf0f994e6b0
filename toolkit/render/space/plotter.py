"""The canvas of a picture of space: panels beside each other, lettering, colour bar, and words at the foot."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypedDict, Unpack

import numpy as np
import pyvista
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D

from toolkit.foundation.files.safe_files import replaced
from toolkit.render.readable_units import FRAME, INK, MINUS, tick_step
from toolkit.render.space.look import ANGLE, ISOMETRIC, Camera


@contextmanager
def canvas(path: Path, width: int, height: int, panels: int) -> Iterator[pyvista.Plotter]:
    """Plotter whose renderer 0 is the white sheet, the last one for a legend, the others panels.

    It is written at the end, in one stroke.
    """
    plotter = pyvista.Plotter(off_screen=True, window_size=[width, height], shape=(1, panels + 2), border=False)
    try:
        plotter.subplot(0, 0)
        plotter.renderers.set_background("white", all_renderers=False)
        plotter.renderers[0].viewport = (0, 0, 1, 1)
        plotter.renderers[-1].DrawOff()  # until there is something to explain
        plotter.enable_anti_aliasing("msaa", multi_samples=8)
        yield plotter
        plotter.render()  # what was drawn after somebody has looked at the sheet
        with replaced(path) as temporary:
            plotter.screenshot(str(temporary), return_img=False)
    finally:
        plotter.close()


def letter(
    plotter: pyvista.Plotter,
    text: str,
    pixel: np.ndarray,
    size: int,
    color: str = INK,
    anchor: tuple[str, str] = ("center", "center"),
) -> pyvista.Text:
    """Write a text at a pixel of the plotter's active renderer; anchor: horizontal and vertical. Returns its actor."""
    # VTK's text takes a bar for the border of columns and a dollar for the start of a formula.
    plain = text.replace("|", "/").replace("$", "")
    actor = plotter.add_text(plain, position=(float(pixel[0]), float(pixel[1])), color=color, render=False)
    actor.prop.font_size = size
    actor.prop.justification_horizontal, actor.prop.justification_vertical = anchor
    return actor


def strokes(plotter: pyvista.Plotter, lines: Sequence[np.ndarray], color: str, width: float) -> None:
    """Draw polylines (n, 2), in pixels, flat on the plotter's active renderer."""
    mapper = vtkPolyDataMapper2D()
    flat = [np.column_stack([points, np.zeros(len(points))]) for points in lines]
    mapper.SetInputData(pyvista.merge([pyvista.lines_from_points(points) for points in flat]))
    actor = vtkActor2D()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*pyvista.Color(color).float_rgb)
    actor.GetProperty().SetLineWidth(max(width, 1.0))
    plotter.renderer.AddViewProp(actor)


Place = tuple[int, int, int, int]
"""Left, bottom, width, height in pixels of the canvas."""
AXES = {"x": "#c0392b", "y": "#1e8449", "z": "#2456a4"}
_PAPER, _GRID = 200, 4
"""Brightness from which a pixel is free for letters, so that faint shapes are; and the distance of the pixels that are looked at."""


class Shine(TypedDict, total=False):
    """How a mesh reflects light, in the words of pyvista."""

    ambient: float
    diffuse: float
    specular: float


class Style(Shine, total=False):
    """What a mesh looks like, in the words of pyvista."""

    color: str
    opacity: float
    lighting: bool
    smooth_shading: bool
    scalars: str
    cmap: Literal["coolwarm", "viridis"]
    clim: tuple[float, float]
    nan_color: str


SHINE: Shine = {"ambient": 0.6, "diffuse": 0.4, "specular": 0.0}
"""Light that leaves colours readable."""


@dataclass(frozen=True)
class SpatialPanel:
    """Rectangle of pixels of the canvas that shows a camera's view, by renderer `number` of the plotter."""

    plotter: pyvista.Plotter
    number: int
    place: Place
    letter: int  # size of letters in pixels
    camera: Camera

    def open(self, framed: bool = True) -> None:
        """Put the renderer in its place, white and on request framed, and the camera before the scene."""
        camera, plotter, (left, bottom, wide, high) = self.camera, self.plotter, self.place
        width, height = plotter.window_size
        plotter.subplot(0, self.number)
        renderer = plotter.renderers[self.number]
        renderer.viewport = (left / width, bottom / height, (left + wide) / width, (bottom + high) / height)
        renderer.DrawOn()
        plotter.renderers.set_background("white", all_renderers=False)
        if framed:
            renderer.add_border(FRAME, 2)
        if camera.perspective:
            renderer.disable_parallel_projection()
        else:
            renderer.enable_parallel_projection()
        plotter.camera_position = [tuple(camera.eye), tuple(camera.focus), tuple(ISOMETRIC[1])]
        plotter.camera.parallel_scale = camera.size[1] / 2
        plotter.camera.view_angle = np.rad2deg(ANGLE)
        plotter.camera.clipping_range = camera.range

    @property
    def scale(self) -> float:
        """Pixels per unit of length at the focus."""
        return float(self.place[3] / self.camera.size[1])

    def pixel(self, points: np.ndarray) -> np.ndarray:
        """Place of points (..., 3) in the panel, in pixels from its lower left corner, (..., 2)."""
        return self.camera.seen(points) * self.scale

    def draw(self, mesh: pyvista.PolyData, **style: Unpack[Style]) -> pyvista.Actor | None:
        """Add a mesh to the panel, without moving the view.

        A mesh without points is nothing to draw, as the tube along a body of two points at one place; some versions of pyvista refuse it.
        """
        if not mesh.n_points:
            return None
        self.plotter.subplot(0, self.number)
        width = self.letter / 22
        return self.plotter.add_mesh(mesh, reset_camera=False, show_scalar_bar=False, render=False, line_width=width, **style)

    def draw_nearer(self, mesh: pyvista.PolyData, shift: float, **style: Unpack[Style]) -> pyvista.Actor | None:
        """Add a mesh that covers what is behind it and up to a length before it."""
        return self.draw(_moved(mesh, self.camera.nearer(mesh.points, shift)), **style)

    def draw_front(self, mesh: pyvista.PolyData, **style: Unpack[Style]) -> None:
        """Add a mesh that covers everything else, as drawing symbols do."""
        self.draw(_moved(mesh, self.camera.before_all(mesh.points)), **style)

    def draw_back(self, mesh: pyvista.PolyData, **style: Unpack[Style]) -> None:
        """Add a mesh that everything else covers."""
        self.draw(_moved(mesh, self.camera.behind_all(mesh.points)), **style)

    def write(self, text: str, pixel: np.ndarray, color: str = INK) -> None:
        """Centre a text at a pixel of the panel, on a light ground that keeps it readable on dark bodies."""
        self.plotter.subplot(0, self.number)
        prop = letter(self.plotter, text, pixel, self.letter, color).prop
        prop.background_color, prop.background_opacity = "white", 0.6

    def covered(self) -> np.ndarray:
        """Places (n, 2) in pixels of the panel where something is drawn: one for every small square that is not white."""
        left, bottom, wide, high = self.place
        self.plotter.render()
        sheet = self.plotter.screenshot(return_img=True)
        assert sheet is not None
        image = sheet[::-1][bottom : bottom + high, left : left + wide]
        inked = (image[..., :3].min(axis=2) < _PAPER)[_GRID // 2 :: _GRID, _GRID // 2 :: _GRID]
        y, x = np.nonzero(inked)
        return _GRID * np.column_stack([x, y]) + _GRID / 2.0

    def compass(self, gravity: np.ndarray | None) -> None:
        """Draw the directions of the axes, and of gravity, below the panel on the right."""
        self.plotter.subplot(0, 0)
        left, bottom, wide, _ = self.place
        origin = np.array([left + wide - 4.0 * self.letter, bottom - 4.5 * self.letter])
        arrows = dict(zip(AXES, np.eye(3), strict=True))
        if gravity is not None and np.any(gravity):
            arrows["g"] = 0.8 * gravity / np.linalg.norm(gravity)
        for name, direction in arrows.items():
            color, end = AXES.get(name, INK), 2.4 * self.letter * (ISOMETRIC[:2] @ direction)
            strokes(self.plotter, arrow_lines(origin, origin + end, 0.4 * self.letter), color, 3 * self.letter / 22)
            beyond = end * (1 + 0.7 * self.letter / max(float(np.linalg.norm(end)), 1e-12))
            letter(self.plotter, name, origin + beyond, self.letter, color)

    def scale_bar(self, unit: str) -> None:
        """Draw a round length below the panel on the left; in perspective there is no one scale."""
        self.plotter.subplot(0, 0)
        left, bottom, wide, _ = self.place
        height = bottom - 1.3 * self.letter
        if self.camera.perspective:
            letter(self.plotter, "perspective", np.array([left, height]), self.letter, INK, ("left", "center"))
            return
        step = tick_step(wide / self.scale / 8)
        end = left + self.scale * step
        ticks = [np.array([[x, height - 0.25 * self.letter], [x, height + 0.25 * self.letter]]) for x in (left, end)]
        strokes(self.plotter, [np.array([[left, height], [end, height]]), *ticks], INK, 2 * self.letter / 22)
        letter(
            self.plotter, f"{step:g} {unit}", np.array([end + 0.6 * self.letter, height]), self.letter, INK, ("left", "center")
        )


def _moved(mesh: pyvista.PolyData, points: np.ndarray) -> pyvista.PolyData:
    found = mesh.copy(deep=False)
    found.points = points
    return found


def arrow_lines(start: np.ndarray, end: np.ndarray, head: float) -> list[np.ndarray]:
    """Shaft and head of a flat arrow, each (n, 2); an arrow towards the eye is a dot."""
    along = end - start
    length = np.linalg.norm(along)
    if length < head:
        return [start + head / 2 * np.array([[-1.0, 0], [0, 1], [1, 0], [0, -1], [-1, 0]])]
    along = along / length
    aside = np.array([-along[1], along[0]])
    barbs = np.array([end - head * (along + aside / 2), end, end - head * (along - aside / 2)])
    return [np.array([start, end]), barbs]


COLUMNS = 2
"""Panels beside each other in an overview."""
_LEFT = ("left", "center")


def overview_places(count: int, width: int, foot: int, aspect: float) -> tuple[list[Place], int]:
    """Places of panels row by row from the top, above a foot of that height and with a margin on the left; and the picture's height.

    `aspect` is the width of a panel over its height.
    """
    letters, columns = width // 60, min(COLUMNS, count)
    rows, left = -(-count // columns), 3 * letters
    wide = (width - left) // columns - letters
    tall, head = round(wide / aspect), 7 * letters // 2
    cells = [divmod(k, columns) for k in range(count)]
    places = [(left + column * (wide + letters), foot + (rows - 1 - row) * (tall + head), wide, tall) for row, column in cells]
    return places, foot + rows * (tall + head)


def head_line(pane: SpatialPanel, title: str) -> None:
    """Write a title above the panel."""
    pane.plotter.subplot(0, 0)
    above = np.array([pane.place[0], pane.place[1] + pane.place[3] + 0.7 * pane.letter])
    letter(pane.plotter, title.replace("-", MINUS), above, pane.letter, INK, ("left", "bottom"))


def color_bar(plotter: pyvista.Plotter, actor: pyvista.Actor, title: str, letters: int) -> None:
    """Draw the colours of an actor at the lower left of the picture."""
    plotter.subplot(0, 0)
    width, height = plotter.window_size
    bar = plotter.add_scalar_bar(
        " ",  # type: ignore[arg-type]  # of a wrapper without a type
        mapper=actor.mapper, vertical=False, n_labels=0, position_x=0.06, position_y=0.7 * letters / height,
        width=0.5, height=3 * letters / height, color=INK, render=False,
    )  # fmt: skip
    bar.SetUnconstrainedFontSize(True)
    low, high = actor.mapper.scalar_range
    for share in np.linspace(0, 1, 5):
        number = f"{low + share * (high - low):.6g}".replace("-", MINUS)
        letter(plotter, number, np.array([(0.06 + 0.5 * share) * width, 2.6 * letters]), letters)
    letter(plotter, title, np.array([0.31 * width, 3.9 * letters]), letters)


def explain(plotter: pyvista.Plotter, meanings: Sequence[tuple[str, str]], left: float, letters: int) -> None:
    """Write words in their colours at the lower edge of the picture, from a pixel on."""
    plotter.subplot(0, 0)
    for k, (text, color) in enumerate(reversed(meanings)):
        letter(plotter, text, np.array([left, (0.8 + 1.3 * k) * letters]), letters, color, _LEFT)
