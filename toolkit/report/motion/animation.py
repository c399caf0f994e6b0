"""The motion as an animated GIF."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from toolkit.render.motion.animation import write_animation
from toolkit.render.plane.configuration import Configuration
from toolkit.render.plane.look import Look
from toolkit.render.plane.scene_picture import instants_alike
from toolkit.render.sheet import NARROW, write_figure
from toolkit.report.material import Material

PIXELS = 728
"""Width."""


def animate(material: Material, path: Path, progress: Callable[[int, int], None] = lambda *_: None) -> Path:
    """Write the motion with the stress of the skins; the file is looped by whatever shows it."""
    drawn = instants_alike(NARROW)

    def frame(moment: Configuration, look: Look, file: Path, width: int) -> None:
        write_figure(drawn(moment, look), file, width / NARROW)

    write_animation([material.moment(step) for step in material.shown], frame, material.look, path, PIXELS, progress)
    return path
