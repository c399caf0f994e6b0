"""Letters and flat strokes on the canvas, in pixels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyvista
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D

from toolkit.render.colors import INK


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
    flat = [np.column_stack([points, np.zeros(len(points))]) for points in lines]
    mapper.SetInputData(pyvista.merge([pyvista.lines_from_points(points) for points in flat]))
    actor = vtkActor2D()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*pyvista.Color(color).float_rgb)
    actor.GetProperty().SetLineWidth(max(width, 1.0))
    plotter.renderer.AddViewProp(actor)
