"""A planar skin with its stress as a mesh of VTK."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista

from toolkit.render.paraview.mechanism_lines import lifted
from toolkit.render.plane.skin_shape import SkinShape


def skin_mesh(shape: SkinShape, thickness: float, name: str) -> Any:
    """The skin as two bands, middle line to outer and to inner fibre, each with the stress of its fibre as point data of that name."""
    fibres = shape.fibres(thickness)
    edges = np.stack([fibres, np.broadcast_to(shape.line[:, :, None], fibres.shape)], axis=3)  # (n_e, points, fibre, edge, 2)
    n = np.arange(edges[..., 0].size).reshape(edges.shape[:4])
    quads = np.stack([n[:, :-1, :, 0], n[:, 1:, :, 0], n[:, 1:, :, 1], n[:, :-1, :, 1]], axis=-1).reshape(-1, 4)
    faces = np.column_stack([np.full(len(quads), 4), quads])
    mesh = pyvista.PolyData(lifted(edges.reshape(-1, 2)), faces=faces.ravel())
    mesh.point_data[name] = np.repeat(shape.stress.ravel(), 2)
    return mesh
