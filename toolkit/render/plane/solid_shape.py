"""The deformed boundary of a meshed body in the plane, and the stress along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.planar.flexible import Flexible
from toolkit.render.plane.configuration import Configuration
from toolkit.responses.stress.stress import stress_components

POINTS = 5
"""Points of an edge, which is a parabola through three nodes."""


@dataclass(frozen=True)
class SolidShape:
    """A meshed body as drawn."""

    edges: np.ndarray  # (n_edges, POINTS, 2), global
    stress: np.ndarray  # (n_edges,) along each edge, in its middle; nan where the model tells another component, or none


def solid_shape(moment: Configuration, body: str) -> SolidShape | None:
    """Shape of a flexible body at one step; None if its reduced model has no outline."""
    found, scene = moment.scene.body(body), moment.scene
    if not isinstance(found, Flexible) or isinstance(found, CutBody):
        return None
    outline = scene.model(found.model, "outline", "stress").outline
    if outline is None:
        return None
    elastic = moment.elastic(body)
    nodes = moment.place(body, outline.position @ np.append(1.0, elastic))
    first, middle, last = (nodes[outline.edges[:, k]] for k in range(3))
    middle = np.where((outline.edges[:, 0] == outline.edges[:, 1])[:, None], (first + last) / 2, middle)
    r = np.linspace(0, 1, POINTS)[:, None]
    edges = (1 - r) * (1 - 2 * r) * first[:, None] + 4 * r * (1 - r) * middle[:, None] + r * (2 * r - 1) * last[:, None]
    stress = np.real(stress_components(scene, body, elastic))[:, 0]
    return SolidShape(edges, stress if len(stress) == len(edges) else np.full(len(edges), np.nan))
