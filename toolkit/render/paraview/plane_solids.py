"""Meshed bodies of the plane for ParaView."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista

from toolkit.foundation.units import unit
from toolkit.render.paraview.mechanism_lines import lifted
from toolkit.render.paraview.solid_stress import add_stress
from toolkit.render.plane.configuration import Configuration
from toolkit.render.plane.solid_shape import solid_shape


def plane_solid(moment: Configuration, body: str) -> Any:
    """Its section with the point data "von Mises stress in <unit>" and "stress in <unit>", six components in the body's own axes.

    None where its model does not tell the stress inside.
    """
    shape = solid_shape(moment, body)
    if shape is None or shape.inside is None:
        return None
    corners = shape.inside.triangles
    faces = np.column_stack([np.full(len(corners), 3), corners])
    mesh = pyvista.PolyData(lifted(shape.inside.points), faces=faces.ravel())
    add_stress(mesh, shape.inside.components, f"stress in {unit(moment.scene.units, 'stress')}")
    return mesh
