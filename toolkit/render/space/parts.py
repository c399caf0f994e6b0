"""The parts of a picture of space as meshes: surfaces with their stress, tubes, coils, arrows."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pyvista

from toolkit.render.space.body_shape import BodyShape

STRESS = "stress"


def whole(shape: BodyShape) -> Any:
    """Mesh of triangles, sides and lines together."""
    faces = [np.column_stack([np.full(len(each), each.shape[1]), each]).ravel() for each in (shape.triangles, *shape.sides)]
    lines = np.column_stack([np.full(len(shape.lines), 2), shape.lines]).ravel()
    mesh: Any = pyvista.PolyData()
    mesh.points, mesh.faces, mesh.lines = shape.points, np.concatenate(faces).astype(int), lines.astype(int)
    return mesh


def surface(shape: BodyShape, values: np.ndarray | None = None) -> Any:
    """Mesh of the triangles of a solid and the sides of beams, with values at their points."""
    return _valued(whole(replace(shape, lines=shape.lines[:0])), values)


def fibres(shape: BodyShape, values: np.ndarray | None = None) -> Any:
    """Mesh of the lines of beams, with values at their points."""
    return _valued(whole(replace(shape, triangles=shape.triangles[:0], sides=())), values)


def _valued(mesh: Any, values: np.ndarray | None) -> Any:
    if values is not None:
        mesh.point_data[STRESS] = values
    return mesh


def clamped_faces(shape: BodyShape) -> Any:
    """Mesh of the triangles that no coordinate moves."""
    fixed = shape.triangles[shape.still[shape.triangles].all(axis=1)]
    return surface(replace(shape, triangles=fixed, sides=()))


def edges(shape: BodyShape, angle: float = 40.0) -> Any:
    """Lines where the surface of a solid has an edge."""
    mesh = surface(replace(shape, sides=()))
    return mesh.extract_feature_edges(feature_angle=angle, boundary_edges=True, non_manifold_edges=False, manifold_edges=False)


def rod(ends: np.ndarray, radius: float) -> Any:
    """Closed cylinder along a line (n, 3)."""
    return pyvista.lines_from_points(ends).tube(radius=radius, n_sides=24, capping=True)


def ball(point: np.ndarray, radius: float) -> Any:
    """Sphere around a point."""
    return pyvista.Sphere(radius=radius, center=point, theta_resolution=24, phi_resolution=24)


def coil(ends: np.ndarray, radius: float, turns: int = 9) -> np.ndarray:
    """Points of a helical spring between two points, straight at its ends, (n, 3)."""
    along = ends[1] - ends[0]
    aside = np.linalg.svd(along[None])[2][1:]
    s = np.linspace(0, 1, 16 * turns + 1)
    angle = 2 * np.pi * turns * s
    out = radius * (np.outer(np.cos(angle), aside[0]) + np.outer(np.sin(angle), aside[1]))
    return np.vstack([ends[0], ends[0] + np.outer(0.15 + 0.7 * s, along) + out, ends[1]])


def arrow(point: np.ndarray, vector: np.ndarray, radius: float, heads: int) -> Any:
    """Arrow from a point, with one head, or with two as a torque has."""
    length = float(np.linalg.norm(vector))
    along, head = vector / length, min(5 * radius, length / (heads + 1))
    shaft = pyvista.Cylinder(
        center=point + along * (length - head) / 2, direction=along, radius=0.6 * radius, height=length - head, resolution=24
    )
    cones = [
        pyvista.Cone(
            center=point + along * (length - head * (k + 0.5)), direction=along, height=head, radius=1.6 * radius, resolution=32
        )
        for k in range(heads)
    ]
    return pyvista.PolyData().append_polydata(*(mesh.triangulate() for mesh in (shaft, *cones)))
