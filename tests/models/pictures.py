"""What tests of pictures share: solutions that need no solver, and what a picture file holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from toolkit.render.packages import RenderError, drawing_environment
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene


def rest(scene: Scene, steps: int, design: list[str] | None = None) -> Solution:
    """A solution that stays in the undeformed state."""
    system = compile_scene(scene, design)
    q = np.tile(system.start()[0][: system.n_q], (steps + 1, 1))
    zero, none = np.zeros_like(q), np.zeros((*q.shape, system.n_x))
    multipliers = np.zeros((steps + 1, system.n - system.n_q))
    times = np.linspace(0, 1, steps + 1)
    return Solution(system, times, q, zero, zero, multipliers, none, none, none, np.zeros((*multipliers.shape, system.n_x)))


def skip_where_nothing_draws() -> None:
    """Skip where no picture can be drawn, and say why."""
    try:
        drawing_environment()
    except RenderError as error:
        pytest.skip(f"OpenGL is missing: {error}")


def image(path: Path) -> np.ndarray:
    """Pixels of a picture, (height, width, channels)."""
    from PIL import Image

    with Image.open(path) as opened:
        return np.asarray(opened)


def distinct_colors(pixels: np.ndarray) -> int:
    """Number of colours of pixels (h, w, k) of bytes; one number for each pixel sorts ten times faster than rows of bytes."""
    return len(np.unique(pixels.astype(np.int64) @ 256 ** np.arange(pixels.shape[2])))
