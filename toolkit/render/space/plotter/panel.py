"""One panel of a picture of space: what a camera sees, its axes and its scale."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.render.colors import FRAME, INK
from toolkit.render.round_numbers import tick_step
from toolkit.render.space.camera import ANGLE, ISOMETRIC, Camera
from toolkit.render.space.plotter.lettering import letter, strokes

Place = tuple[int, int, int, int]
"""Left, bottom, width, height in pixels of the canvas."""
AXES = {"x": "#c0392b", "y": "#1e8449", "z": "#2456a4"}
_PAPER, _GRID = 200, 4
"""Brightness from which a pixel is free for letters, so that faint shapes are; and the distance of the pixels that are looked at."""


@dataclass(frozen=True)
class SpatialPanel:
    """Rectangle of pixels of the canvas that shows a camera's view, by renderer `number` of the plotter."""

    plotter: Any
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
        plotter.set_background("white", all_renderers=False)
        if framed:
            renderer.add_border(FRAME, 2)
        if camera.perspective:
            plotter.disable_parallel_projection()
        else:
            plotter.enable_parallel_projection()
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

    def draw(self, mesh: Any, **style: Any) -> Any:
        """Add a mesh to the panel, without moving the view; `line_width` is that of a picture 1600 pixels wide.

        A mesh without points is nothing to draw, as the tube along a body of two points at one place; some versions of pyvista refuse it.
        """
        if not mesh.n_points:
            return None
        self.plotter.subplot(0, self.number)
        style["line_width"] = style.get("line_width", 1) * self.letter / 22
        return self.plotter.add_mesh(mesh, reset_camera=False, show_scalar_bar=False, render=False, **style)

    def draw_nearer(self, mesh: Any, shift: float, **style: Any) -> Any:
        """Add a mesh that covers what is behind it and up to a length before it."""
        return self.draw(_moved(mesh, self.camera.nearer(mesh.points, shift)), **style)

    def draw_front(self, mesh: Any, **style: Any) -> Any:
        """Add a mesh that covers everything else, as drawing symbols do."""
        return self.draw(_moved(mesh, self.camera.before_all(mesh.points)), **style)

    def draw_back(self, mesh: Any, **style: Any) -> Any:
        """Add a mesh that everything else covers."""
        return self.draw(_moved(mesh, self.camera.behind_all(mesh.points)), **style)

    def write(self, text: str, pixel: np.ndarray, color: str = INK) -> None:
        """Centre a text at a pixel of the panel, on a light ground that keeps it readable on dark bodies."""
        self.plotter.subplot(0, self.number)
        prop = letter(self.plotter, text, pixel, self.letter, color).prop
        prop.background_color, prop.background_opacity = "white", 0.6

    def covered(self) -> np.ndarray:
        """Places (n, 2) in pixels of the panel where something is drawn: one for every small square that is not white."""
        left, bottom, wide, high = self.place
        self.plotter.render()
        image = self.plotter.screenshot(return_img=True)[::-1][bottom : bottom + high, left : left + wide]
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


def _moved(mesh: Any, points: np.ndarray) -> Any:
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
