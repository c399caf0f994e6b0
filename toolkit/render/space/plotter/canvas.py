"""The sheet that panels and lettering are put on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyvista

from toolkit.foundation.files.replaced_file import replaced


@contextmanager
def canvas(path: Path, width: int, height: int, panels: int) -> Iterator[Any]:
    """Plotter whose renderer 0 is the white sheet, the last one for a legend, the others panels.

    It is written at the end, in one stroke.
    """
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=[width, height], shape=(1, panels + 2), border=False)
    try:
        plotter.subplot(0, 0)
        plotter.set_background("white", all_renderers=False)
        plotter.renderers[0].viewport = (0, 0, 1, 1)
        plotter.renderers[-1].DrawOff()  # until there is something to explain
        plotter.enable_anti_aliasing("msaa", multi_samples=8)
        yield plotter
        plotter.render()  # what was drawn after somebody has looked at the sheet
        with replaced(path) as temporary:
            plotter.screenshot(str(temporary), return_img=False)
    finally:
        plotter.close()
