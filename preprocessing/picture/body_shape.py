"""The undeformed body as lines and triangles, from what its reduced model keeps for pictures."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.reduced_model.model import Outline, ReducedModel

CURVE = 8
"""Straight parts of a curved edge."""


class BodyShape(NamedTuple):
    """What is drawn of a body; all of them may be empty."""

    triangles: np.ndarray  # (n, 3, 3) corners of the surface in space
    lines: list[np.ndarray]  # (n_points, d) polylines: the outline in the plane, the fibres of beams
    nodes: np.ndarray  # (n, d) of beams in the plane


def body_shape(model: ReducedModel) -> BodyShape:
    """The undeformed surface or outline of a body."""
    none = BodyShape(np.zeros((0, 3, 3)), [], np.zeros((0, model.dimension)))
    if model.surface is not None:
        points = np.real(model.surface.position[:, :, 0])
        return none._replace(triangles=points[model.surface.triangles], lines=[*points[model.surface.lines]])
    if model.outline is not None:
        return none._replace(lines=_curves(model.outline))
    if model.mesh is not None:
        return none._replace(lines=[model.mesh.outline], nodes=model.mesh.nodes)
    return none


def _curves(outline: Outline) -> list[np.ndarray]:
    """The edges of a boundary; those with a middle node are parabolas."""
    points = np.real(outline.position[:, :, 0])
    first, middle, last = (points[outline.edges[:, k]][:, None] for k in range(3))
    straight = outline.edges[:, 0] == outline.edges[:, 1]
    middle = np.where(straight[:, None, None], (first + last) / 2, middle)
    t = np.linspace(0, 1, CURVE + 1)[None, :, None]
    return [*((1 - t) * (1 - 2 * t) * first + 4 * t * (1 - t) * middle + t * (2 * t - 1) * last)]
