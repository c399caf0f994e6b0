"""How a picture is laid out: panels beside each other, the line above a panel, colour bar and words at the foot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from toolkit.render.colors import INK
from toolkit.render.round_numbers import MINUS
from toolkit.render.space.plotter.lettering import letter
from toolkit.render.space.plotter.panel import Place, SpatialPanel

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


def color_bar(plotter: Any, actor: Any, title: str, letters: int) -> None:
    """Draw the colours of an actor at the lower left of the picture."""
    plotter.subplot(0, 0)
    width, height = plotter.window_size
    bar = plotter.add_scalar_bar(
        " ", mapper=actor.mapper, vertical=False, n_labels=0, position_x=0.06, position_y=0.7 * letters / height,
        width=0.5, height=3 * letters / height, color=INK, render=False,
    )  # fmt: skip
    bar.SetUnconstrainedFontSize(True)
    low, high = actor.mapper.scalar_range
    for share in np.linspace(0, 1, 5):
        number = f"{low + share * (high - low):.6g}".replace("-", MINUS)
        letter(plotter, number, np.array([(0.06 + 0.5 * share) * width, 2.6 * letters]), letters)
    letter(plotter, title, np.array([0.31 * width, 3.9 * letters]), letters)


def explain(plotter: Any, meanings: Sequence[tuple[str, str]], left: float, letters: int) -> None:
    """Write words in their colours at the lower edge of the picture, from a pixel on."""
    plotter.subplot(0, 0)
    for k, (text, color) in enumerate(reversed(meanings)):
        letter(plotter, text, np.array([left, (0.8 + 1.3 * k) * letters]), letters, color, _LEFT)
