"""The deformed surface of a flexible body in space, and the stress on it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.cut.framed_part import FramedPart
from toolkit.bodies.flexible import SpatialFlexible
from toolkit.reduced_model.cut.spatial_part import rows_of_pieces
from toolkit.reduced_model.model import StressPoints
from toolkit.reduced_model.parts.pieces import Pieces
from toolkit.reduced_model.spatial_model import SURFACE_POSITION, Surface
from toolkit.render.space.configuration import SpatialConfiguration
from toolkit.responses.stress.stress import stress_components
from toolkit.scene.resolution import ResolvedScene

UNSEEN = ("youngs_modulus", "density", "poisson_ratio", "damping")
"""Beginnings of the names of parameters that no picture shows."""
STILL = 1e-12
"""Motion of a point by the elastic coordinates that is round-off, relative to the largest."""


@dataclass(frozen=True)
class BodyShape:
    """Flexible body as drawn: triangles of a solid, or lines for the fibres of beams, with the sides of their elements."""

    points: np.ndarray  # (n, 3), global
    triangles: np.ndarray  # (n_triangles, 3)
    lines: np.ndarray  # (n_lines, 2)
    sides: tuple[np.ndarray, ...]  # (n, k) polygons round the elements of beams: between neighbouring fibres, and at both ends
    stress: np.ndarray  # (n, 6) or (n, 1); nan where the model tells none
    still: np.ndarray  # (n,) whether no elastic coordinate moves the point


def has_shape(scene: ResolvedScene, body: str) -> bool:
    """Whether a flexible body's reduced model contains its surface."""
    found = scene.body(body)
    return isinstance(found, SpatialFlexible) and scene.model(found.model, "surface").surface is not None


def drawn_as_built(scene: ResolvedScene, body: str) -> bool:
    """Whether a scene gives a body other sizes or form than its reduced model has, while its drawn surface is the model's."""
    found = scene.body(body)
    assert isinstance(found, SpatialFlexible)
    nominal = scene.model(found.model).nominal
    changed = [
        name
        for name, value in found.model_values().items()
        if not name.startswith(UNSEEN) and np.real(value) != nominal.get(name)
    ]
    if not changed:
        return False
    model = found.design_point(scene, "surface").model
    told = (model.affine or {}).get(SURFACE_POSITION)
    return told is None or not all(told.depends_on(model.numbers[name]) for name in changed)


def body_shape(moment: SpatialConfiguration, body: str) -> BodyShape:
    """Shape of a flexible body that has one, at one step."""
    return moment.once(("body shape", body), lambda: _body_shape(moment, body))


def _body_shape(moment: SpatialConfiguration, body: str) -> BodyShape:
    found, scene = moment.scene.body(body), moment.scene
    assert isinstance(found, SpatialFlexible)
    model, elastic = scene.model(found.model, "surface", "stress"), moment.elastic(body)
    surface, stress = model.surface, np.real(stress_components(scene, body, elastic))
    assert surface is not None
    points = _points(moment, body, surface)
    told = at_points(surface, stress)
    moved = np.abs(surface.position[:, :, 1:]).max(axis=(1, 2), initial=0)
    still = moved <= STILL * moved.max(initial=0)
    return BodyShape(points, surface.triangles, surface.lines, _sides(surface, model.stress), told, still)


def _points(moment: SpatialConfiguration, body: str, surface: Surface) -> np.ndarray:
    """The surface's points in space, (n, 3); of a cut body from the fibres of its parts."""
    found, scene = moment.scene.body(body), moment.scene
    if not isinstance(found, CutBody):
        assert isinstance(found, SpatialFlexible)
        position = np.real(found.design_point(scene, "surface").value(SURFACE_POSITION))
        return moment.place(body, position @ np.append(1.0, moment.elastic(body)))
    points = np.full(surface.position.shape[:2], np.nan)
    for name, part in found.parts(body).items():
        assert isinstance(part, FramedPart)
        own = part.design_point(scene).model.surface
        if own is not None:
            rows = _rows(surface, scene.model(found.model, "pieces").pieces, part, scene)
            points[rows] = moment.place(name, own.position @ np.append(1.0, moment.elastic(name)))
    return points


def _rows(surface: Surface, pieces: Pieces | None, part: FramedPart, scene: ResolvedScene) -> np.ndarray:
    """Numbers of the surface points that a part of a cut body contains."""
    if pieces is not None:
        return rows_of_pieces(pieces, part.first, part.last)
    found: np.ndarray = surface.lines.ravel()[part.part(scene).stress_rows]
    return found


def at_points(surface: Surface, values: np.ndarray) -> np.ndarray:
    """Values at the stress points (n_s, ...), the surface's points in their order or the ends of its lines, at all its points (n, ...).

    They are nan where the model does not say where its stress points are.
    """
    rows = surface.lines.ravel() if len(surface.lines) else np.arange(len(surface.position))
    told = np.full((len(surface.position), *values.shape[1:]), np.nan)
    if len(rows) == len(values):
        told[rows] = values
    return told


def _sides(surface: Surface, stress: StressPoints | None) -> tuple[np.ndarray, ...]:
    """Polygons round every element that has three fibres or more, in the order in which they stand round the undeformed section."""
    if stress is None or len(stress.element) != surface.lines.size or not len(surface.lines):
        return ()
    element = stress.element.reshape(-1, 2)[:, 0]
    found: dict[int, list[np.ndarray]] = {}
    starts = np.append(np.flatnonzero(np.diff(element, prepend=element[0] - 1)), len(element))
    for first, last in pairwise(starts):
        fibres = surface.lines[first:last]
        if len(fibres) > 2:
            ring = fibres[_turn(surface.position[fibres, :, 0])]
            found.setdefault(len(ring), []).append(ring.T)
            found.setdefault(4, []).append(np.column_stack([ring, np.roll(ring, -1, axis=0)[:, ::-1]]))
    return tuple(np.concatenate(each) for each in found.values())


def _turn(ends: np.ndarray) -> np.ndarray:
    """Order of an element's fibres (n, 2, 3) by their angle around its axis."""
    axis = (ends[:, 1] - ends[:, 0]).mean(axis=0)
    out = ends[:, 0] - ends[:, 0].mean(axis=0)
    first = out[0] / max(np.linalg.norm(out[0]), np.finfo(float).tiny)
    second = np.cross(axis, first)
    return np.argsort(np.arctan2(out @ second / max(np.linalg.norm(axis), np.finfo(float).tiny), out @ first), kind="stable")
