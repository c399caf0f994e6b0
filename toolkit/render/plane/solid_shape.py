"""A meshed body in the plane as it is deformed: its boundary with the stress along it, and the stress inside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.flexible import Flexible
from toolkit.foundation.near_ties import first_largest
from toolkit.render.plane.configuration import Configuration
from toolkit.responses.stress.stress import stress_components
from toolkit.responses.stress.von_mises import point_stress
from toolkit.system.flexible_bodies import design_point

POINTS = 5
"""Points of an edge, which is a parabola through three nodes."""


PLACES = (0, 1, 2, 5)
"""Places of the components xx, yy, zz, xy among the six in space."""


@dataclass(frozen=True)
class Inside:
    """Interior of a meshed body as drawn."""

    points: np.ndarray  # (n, 2), global
    triangles: np.ndarray  # (n_triangles, 3)
    components: np.ndarray  # (n, 6) xx, yy, zz, yz, xz, xy in the body's axes

    @property
    def stress(self) -> np.ndarray:
        """Von Mises' stress (n,), negative in compression (xx + yy < 0): on a free edge in plane stress it is the stress along the edge."""
        pressed = self.components[:, 0] + self.components[:, 1] < 0
        return np.where(pressed, -1.0, 1.0) * point_stress(self.components)


@dataclass(frozen=True)
class SolidShape:
    """Meshed body as drawn."""

    edges: np.ndarray  # (n_edges, POINTS, 2), global
    stress: np.ndarray  # (n_edges,) along each edge, in its middle; nan where the model tells another component, or none
    inside: Inside | None = None

    @property
    def shown(self) -> np.ndarray:
        """Stress that pictures show: inside, or else along the boundary."""
        return self.stress if self.inside is None else self.inside.stress

    @property
    def deepest(self) -> np.ndarray:
        """Place (2,) furthest from the boundary; the middle of the boundary if nothing inside is known."""
        border = self.edges.reshape(-1, 2)
        if self.inside is None:
            return border.mean(axis=0)
        depth, _ = cKDTree(border).query(self.inside.points)
        return self.inside.points[first_largest(depth)]


def solid_shape(moment: Configuration, body: str) -> SolidShape | None:
    """Shape of a flexible body at one step; None if its reduced model has no outline."""
    return moment.once(("solid shape", body), lambda: _solid_shape(moment, body))


def _solid_shape(moment: Configuration, body: str) -> SolidShape | None:
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
    told = stress if len(stress) == len(edges) else np.full(len(edges), np.nan)
    return SolidShape(edges, told, _inside(moment, body, elastic))


def _inside(moment: Configuration, body: str, elastic: np.ndarray) -> Inside | None:
    """Interior of a meshed body with its stress; None if the model has none, or stands off its nominal design along a tangent.

    The stress there is not in the file.
    """
    point = design_point(moment.scene, body, "interior")
    interior = point.model.interior
    if interior is None or point.extrapolated():
        return None
    points = moment.place(body, interior.position @ np.append(1.0, elastic))
    components = np.zeros((len(points), 6))
    components[:, PLACES] = np.real(point.parameter(int(interior.modulus)) * (interior.stress @ elastic))
    return Inside(points, interior.triangles, components)
