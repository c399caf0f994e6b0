"""The parts of a picture of space as meshes: surfaces with their stress, tubes, coils, arrows."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pyvista
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from toolkit.components.bodies.rigid import SpatialRigidBody
from toolkit.components.joints.joint import Joint, SpatialJoint
from toolkit.foundation.errors import InputError, listed
from toolkit.foundation.kinematics.orientation import axes_along
from toolkit.render.space.configuration import BodyShape, SpatialConfiguration, body_shape, has_shape

STRESS = "stress"


def whole(shape: BodyShape) -> pyvista.PolyData:
    """Mesh of triangles, sides and lines together."""
    faces = [np.column_stack([np.full(len(each), each.shape[1]), each]).ravel() for each in (shape.triangles, *shape.sides)]
    lines = np.column_stack([np.full(len(shape.lines), 2), shape.lines]).ravel()
    mesh = pyvista.PolyData()
    mesh.points, mesh.faces, mesh.lines = shape.points, np.concatenate(faces).astype(int), lines.astype(int)
    return mesh


def surface(shape: BodyShape, values: np.ndarray | None = None) -> pyvista.PolyData:
    """Mesh of the triangles of a solid and the sides of beams, with values at their points."""
    return _valued(whole(replace(shape, lines=shape.lines[:0])), values)


def fibres(shape: BodyShape, values: np.ndarray | None = None) -> pyvista.PolyData:
    """Mesh of the lines of beams, with values at their points."""
    return _valued(whole(replace(shape, triangles=shape.triangles[:0], sides=())), values)


def _valued(mesh: pyvista.PolyData, values: np.ndarray | None) -> pyvista.PolyData:
    if values is not None:
        mesh.point_data[STRESS] = values
    return mesh


def clamped_faces(shape: BodyShape) -> pyvista.PolyData:
    """Mesh of the triangles that no coordinate moves."""
    fixed = shape.triangles[shape.still[shape.triangles].all(axis=1)]
    return surface(replace(shape, triangles=fixed, sides=()))


def edges(shape: BodyShape, angle: float = 40.0) -> pyvista.PolyData:
    """Lines where the surface of a solid has an edge."""
    mesh = surface(replace(shape, sides=()))
    return mesh.extract_feature_edges(feature_angle=angle, boundary_edges=True, non_manifold_edges=False, manifold_edges=False)


def rod(ends: np.ndarray, radius: float) -> pyvista.PolyData:
    """Closed cylinder along a line (n, 3)."""
    return pyvista.lines_from_points(ends).tube(radius=radius, n_sides=24, capping=True)


def ball(point: np.ndarray, radius: float) -> pyvista.PolyData:
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


def arrow(point: np.ndarray, vector: np.ndarray, radius: float, heads: int) -> pyvista.PolyData:
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


class SpatialSymbol(NamedTuple):
    """A symbol at a point (3,), its own axes (3, 3), as columns, turned with the body that carries it."""

    kind: str
    point: np.ndarray
    axes: np.ndarray
    grounded: bool = False

    def surface(self, size: float) -> pyvista.PolyData:
        """Surface that draws the symbol; `size` is about the radius of its parts."""
        mesh = _SURFACES[self.kind]()
        placed = np.eye(4)
        placed[:3, :3], placed[:3, 3] = size * self.axes, self.point
        return mesh.transform(placed, inplace=False)


def spatial_symbols(moment: SpatialConfiguration) -> list[SpatialSymbol]:
    """Symbols of joints, grounds and clamps of a scene; a named point without any of these, and without a ball, is a pin."""
    found = [symbol for joint in moment.joints() for symbol in _joint_symbols(moment, joint)]
    for link in moment.links():
        for (body, _), end in zip(link.grips, moment.ends(link), strict=True):
            found += [*_ground(end, body == "ground"), SpatialSymbol("pin", end, np.eye(3), body == "ground")]
    found += [SpatialSymbol("weld", point, np.eye(3), True) for point in clamped_points(moment)]
    found += [symbol for body in moment.scene.bodies for symbol in _bearing(moment, body)]
    marked = [
        *(symbol.point for symbol in found),
        *(moment.centre(body) for body in moment.scene.bodies if moment.has_ball(body)),
    ]
    return found + [SpatialSymbol("pin", point, np.eye(3)) for point in moment.bare_points(marked)]


def _bearing(moment: SpatialConfiguration, body: str) -> list[SpatialSymbol]:
    """Hinge on the ground that a turning frame is drawn with."""
    found = moment.spatial_body(body)
    if found.frame != "turning":
        return []
    origin = np.real(found.frame_origin(moment.scene)) if isinstance(found, SpatialRigidBody) else moment.frame(body)[0]
    return [*_ground(origin, True), SpatialSymbol("hinge", origin, axes_along(found.unit_axis))]


def clamped_points(moment: SpatialConfiguration) -> list[np.ndarray]:
    """Middles of the clamped places of grounded bodies: sections of beams, and connected parts of a solid's surface."""
    found: list[np.ndarray] = []
    for body in moment.flexible():
        if moment.spatial_body(body).frame == "grounded" and has_shape(moment.scene, body):
            shape = body_shape(moment, body)
            found += _clamped_sections(shape) + _clamped_parts(shape)
    return found


def _clamped_sections(shape: BodyShape) -> list[np.ndarray]:
    """Middles of clamped beam sections; ends of fibres that are close to each other belong to one section."""
    fixed, found = shape.points[shape.lines.ravel()[shape.still[shape.lines.ravel()]]], []
    reach = np.linalg.norm(np.ptp(shape.points, axis=0)) / 20
    while len(fixed):
        near = np.linalg.norm(fixed - fixed[0], axis=1) < reach
        found.append(fixed[near].mean(axis=0))
        fixed = fixed[~near]
    return found


def _clamped_parts(shape: BodyShape) -> list[np.ndarray]:
    """Middles of clamped parts of a surface; triangles that share points belong to one part."""
    fixed, n = shape.triangles[shape.still[shape.triangles].all(axis=1)], len(shape.points)
    links = coo_array((np.ones(2 * len(fixed)), (np.tile(fixed[:, 0], 2), fixed[:, 1:].T.ravel())), (n, n))
    part = connected_components(links, directed=False)[1][fixed[:, 0]]
    return [shape.points[np.unique(fixed[part == each])].mean(axis=0) for each in np.unique(part)]


def _joint_symbols(moment: SpatialConfiguration, joint: Joint) -> list[SpatialSymbol]:
    """Symbols of joints where body a is gripped, with the axes of body b, in which a slide's axis is fixed."""
    if not isinstance(joint, SpatialJoint) or not joint.symbol:
        return []
    kind, grounded = joint.symbol, "ground" in joint.bodies
    if kind not in _SURFACES:
        known = listed(_SURFACES)
        raise InputError(f"{type(joint).__name__} has the symbol {kind!r}, which nobody can draw; take one of: {known}.")
    point, base = moment.ends(joint)
    own = joint.axes
    before = np.eye(3) if own is None else np.real(own)
    axes = moment.turned(*joint.grips[1], before)
    if kind == "weld":
        return [SpatialSymbol(kind, point, np.eye(3), True)] if grounded else []
    if kind == "cross":
        first = moment.turned(*joint.grips[0], before)[:, 0]
        axes = np.column_stack([first, axes[:, 1], np.cross(first, axes[:, 1])])
    if kind in ("slider", "sleeve"):
        return [SpatialSymbol(kind, point, axes), SpatialSymbol("rails" if kind == "slider" else "rail", point, axes, grounded)]
    if kind == "plane":
        off = axes[:, 2] * (axes[:, 2] @ (base - point))
        return [SpatialSymbol("pin", point, axes), SpatialSymbol(kind, point + off, axes, grounded)]
    return [*_ground(point, grounded), SpatialSymbol(kind, point, axes)]


def _ground(point: np.ndarray, grounded: bool) -> list[SpatialSymbol]:
    return [SpatialSymbol("ground", point, np.eye(3), True)] if grounded else []


def _cylinder(
    direction: tuple[float, ...], radius: float, height: float, center: tuple[float, ...] = (0, 0, 0)
) -> pyvista.PolyData:
    return pyvista.Cylinder(center=center, direction=direction, radius=radius, height=height, resolution=32)


def _box(x: float, y: float, z: float) -> pyvista.PolyData:
    return pyvista.Box((-x, x, -y, y, -z, z))


def _together(*meshes: pyvista.PolyData) -> pyvista.PolyData:
    return pyvista.PolyData().append_polydata(*(mesh.triangulate() for mesh in meshes))


def _pyramid() -> pyvista.PolyData:
    """Foot below a point, on a plate."""
    cone = pyvista.Cone(center=(0, 0, -1.6), direction=(0, 0, 1), height=3.2, radius=2.4, resolution=4)
    plate = pyvista.Box((-2.6, 2.6, -2.6, 2.6, -3.9, -3.2))
    return _together(cone, plate)


_ALONG = (0.0, 0.0, 1.0)
_SURFACES = {
    "hinge": lambda: _cylinder(_ALONG, 1.1, 5.0),
    "ball": lambda: pyvista.Sphere(radius=1.6, theta_resolution=32, phi_resolution=32),
    "pin": lambda: pyvista.Sphere(radius=0.9, theta_resolution=24, phi_resolution=24),
    "sleeve": lambda: _cylinder(_ALONG, 1.5, 4.0),
    "rail": lambda: _cylinder(_ALONG, 0.5, 14.0),
    "slider": lambda: _box(1.6, 1.6, 2.2),
    "rails": lambda: _together(*(_cylinder(_ALONG, 0.35, 14.0, (x, y, 0)) for x in (-2.0, 2.0) for y in (-2.0, 2.0))),
    "plane": lambda: _box(5.0, 5.0, 0.1),
    "cross": lambda: _together(_cylinder((1.0, 0.0, 0.0), 0.8, 5.0), _cylinder((0.0, 1.0, 0.0), 0.8, 5.0)),
    "weld": lambda: _box(1.7, 1.7, 1.7),
    "ground": _pyramid,
}
