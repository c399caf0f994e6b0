"""One panel of a picture: its frame and lettering; and a window on the plane with its axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyvista
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D

from toolkit.render import parts

Place = tuple[int, int, int, int]
"""Left, bottom, width, height in pixels of the canvas."""

INK, FRAME = "#202020", "#808080"
_MOST_TICKS, _FEWEST_TICKS = 10, 5  # about, along the longer and along the shorter side
_GAP = 6  # pixels between an edge and the numbers of its ticks


@dataclass(frozen=True)
class Window:
    """A rectangle of the plane: lower left corner and size, in the scene's unit of length."""

    corner: np.ndarray  # (2,)
    size: np.ndarray  # (2,)

    @classmethod
    def around(cls, points: np.ndarray, aspect: float, margin: float) -> Window:
        """The smallest window of an aspect (width over height) around points (n, 2), with a margin relative to their extent."""
        low, high = points.min(axis=0), points.max(axis=0)
        size = (high - low) + 2 * margin * max(np.ptp(points, axis=0).max(), 1e-12)
        size = np.maximum(size, [size[1] * aspect, size[0] / aspect])
        return cls((low + high - size) / 2, size)

    @property
    def outline(self) -> np.ndarray:
        """Closed line round the window, (5, 2)."""
        return self.corner + self.size * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]])

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Which points lie inside, (n,)."""
        return np.all((points >= self.corner) & (points <= self.corner + self.size), axis=-1)


@dataclass(frozen=True)
class Pane:
    """A rectangle of pixels of the canvas, drawn by renderer `number` of the plotter; what panels in the plane and in space share."""

    plotter: Any
    number: int
    place: Place
    letter: int  # size of letters in pixels

    def clear(self) -> Any:
        """Put the renderer in its place, white and framed; returns it."""
        width, height = self.plotter.window_size
        left, bottom, wide, high = self.place
        self.plotter.subplot(0, self.number)
        renderer = self.plotter.renderers[self.number]
        renderer.viewport = (left / width, bottom / height, (left + wide) / width, (bottom + high) / height)
        self.plotter.set_background("white", all_renderers=False)
        renderer.add_border(FRAME, 2)
        return renderer

    def draw(self, mesh: Any, **style: Any) -> Any:
        """Add a mesh to the panel, without moving the view; `line_width` is that of a picture 1600 pixels wide.

        A mesh without points is nothing to draw, as the tube along a body of two points at one place; some versions of pyvista refuse it.
        """
        if not mesh.n_points:
            return None
        self.plotter.subplot(0, self.number)
        style["line_width"] = style.get("line_width", 1) * self.letter / 22
        return self.plotter.add_mesh(mesh, reset_camera=False, show_scalar_bar=False, render=False, **style)

    def write(self, text: str, pixel: np.ndarray, color: str = INK) -> None:
        """Centre a text at a pixel of the panel."""
        self.plotter.subplot(0, self.number)
        letter(self.plotter, text, pixel, self.letter, color)


@dataclass(frozen=True)
class Panel(Pane):
    """A window of the plane shown in a rectangle of the canvas."""

    window: Window

    def open(self) -> None:
        """Put the renderer in its place, look at the window from above, draw the frame."""
        self.clear()
        x, y = self.window.corner + self.window.size / 2
        self.plotter.enable_parallel_projection()
        distance = 10 * self.window.size.max()
        self.plotter.camera_position = [(x, y, distance), (x, y, 0.0), (0.0, 1.0, 0.0)]
        self.plotter.camera.parallel_scale = self.window.size[1] / 2
        self.plotter.camera.clipping_range = (distance / 2, 2 * distance)

    @property
    def scale(self) -> float:
        """Pixels per unit of length."""
        return self.place[3] / self.window.size[1]

    def pixel(self, point: np.ndarray) -> np.ndarray:
        """Place of points (..., 2) in the panel, in pixels from its lower left corner."""
        return (point - self.window.corner) * self.scale

    def ticks(self, canvas: int, label: str, axes: Sequence[int] = (0, 1)) -> None:
        """Ticks along the lower (axis 0) and the left edge (1), their numbers outside; `canvas` is the whole picture's renderer."""
        left, bottom, wide, _ = self.place
        step = tick_step(min(self.window.size.max() / _MOST_TICKS, self.window.size.min() / _FEWEST_TICKS))
        far = self.window.corner + self.window.size - self.letter / self.scale
        for axis in (0, 1):
            start = self.window.corner[axis] + self.letter / self.scale
            values = multiples(start, far[axis] - start, step)
            self._strokes(axis, values)
            self.plotter.subplot(0, canvas)
            for value in values if axis in axes else ():
                along = (value - self.window.corner[axis]) * self.scale
                at = (left + along, bottom - _GAP) if axis == 0 else (left - _GAP, bottom + along)
                anchor = ("center", "top") if axis == 0 else ("right", "center")
                letter(self.plotter, f"{value:g}", np.array(at), self.letter, INK, anchor)
        if 0 in axes:
            letter(self.plotter, label, np.array([left + wide, bottom - 1.8 * self.letter]), self.letter, INK, ("right", "top"))

    def _strokes(self, axis: int, values: np.ndarray) -> None:
        """Short lines inwards from the edge that the axis runs along."""
        ends = self.window.corner + np.outer([0.0, 0.5 * self.letter / self.scale], [axis, 1 - axis])
        strokes = [np.where([axis == 0, axis == 1], value, ends) for value in values]
        if strokes:
            self.draw(parts.lines(strokes, 0.0), color=FRAME, line_width=2, lighting=False)


def letter(
    plotter: Any, text: str, pixel: np.ndarray, size: int, color: str = INK, anchor: tuple[str, str] = ("center", "center")
) -> Any:
    """Write a text at a pixel of the plotter's active renderer; anchor: horizontal and vertical. Returns its actor."""
    # VTK's text takes a bar for the border of columns and a dollar for the start of a formula.
    plain = text.replace("|", "/").replace("$", "")
    actor = plotter.add_text(plain, position=(float(pixel[0]), float(pixel[1])), color=color, render=False)
    actor.prop.font_size = size
    actor.prop.justification_horizontal, actor.prop.justification_vertical = anchor
    return actor


def strokes(plotter: Any, lines: Sequence[np.ndarray], color: str, width: float) -> None:
    """Draw polylines (n, 2), in pixels, flat on the plotter's active renderer."""
    mapper = vtkPolyDataMapper2D()
    mapper.SetInputData(parts.lines(list(lines), 0.0))
    actor = vtkActor2D()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*pyvista.Color(color).float_rgb)
    actor.GetProperty().SetLineWidth(max(width, 1.0))
    plotter.renderer.AddViewProp(actor)


def tick_step(least: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is not less than a length."""
    power = 10.0 ** np.floor(np.log10(least))
    return float(next(power * digit for digit in (1, 2, 5, 10) if power * digit >= least * (1 - 1e-9)))


def multiples(start: float, length: float, step: float) -> np.ndarray:
    """Multiples of the step in [start, start + length]."""
    return step * np.arange(int(np.ceil(start / step)), int(np.floor((start + length) / step)) + 1)
