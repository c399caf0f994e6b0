"""Rigid bodies and links as lines for ParaView."""

from __future__ import annotations

from typing import Any

import pyvista

from toolkit.render.parts import line


def mechanism(moment: Any) -> Any:
    """Rigid bodies and links of a configuration in the plane or in space as lines, or None."""
    lines = [
        *(ends for body in moment.scene.bodies for ends in moment.segments(body)),
        *(moment.ends(each) for each in moment.links()),
    ]
    drawn = line if moment.scene.dimension == 2 else pyvista.lines_from_points
    return pyvista.PolyData().append_polydata(*map(drawn, lines)) if lines else None
