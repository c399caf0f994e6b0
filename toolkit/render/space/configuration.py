"""A scene in space at one step of a solution: where its bodies, points and axes are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise, product

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from toolkit.components.bodies.body import SpatialBody, SpatialMarkerNumbers
from toolkit.components.bodies.cut_body import CutBody
from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.components.bodies.framed_part import FramedPart
from toolkit.components.bodies.rigid import SpatialRigidBody, SpatialRod
from toolkit.components.joints.joint import AtPoints, SpatialJoint
from toolkit.foundation.kinematics.orientation import matrix_of, quaternion_of
from toolkit.reduced_model.cut_part import rows_of_pieces
from toolkit.reduced_model.model import StressPoints
from toolkit.reduced_model.parts import SURFACE_POSITION, Pieces, Surface
from toolkit.render.moment import Moment
from toolkit.render.readable_units import stress_range
from toolkit.render.sheet import Panels, draw_panels, merged, motion_panels
from toolkit.responses.stress import point_stress, stress_components
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution

FAR = 1e-9
"""Distance from its centre of mass below which a body is gripped there, relative to its radius of gyration."""

BOX_EDGES = 12


@dataclass(frozen=True)
class SpatialConfiguration(Moment):
    """One step of a spatial solution, for drawing."""

    @classmethod
    def undeformed(cls, solution: Solution) -> SpatialConfiguration:
        """Configuration of all bodies before anything has moved."""
        system = solution.system
        return cls(replace(solution, q=np.real(system.undeformed()[0][None, : system.n_q]), times=solution.times[:1]), 0)

    def spatial_body(self, body: str) -> SpatialBody:
        """Body of the given name."""
        found = self.scene.body(body)
        assert isinstance(found, SpatialBody)
        return found

    def elastic(self, body: str) -> np.ndarray:
        """Elastic coordinates q_f of a flexible body, shape (n_f,); of a cut one those of all its parts."""
        found = self.spatial_body(body)
        if isinstance(found, CutBody):
            return self.coordinates(body)[found.elastic_places]
        return self.coordinates(body)[found.frame_size :]

    def rotation(self, body: str) -> np.ndarray:
        """Rotation matrix A (3, 3) of the body's frame; the unit matrix without orientation coordinates."""
        found, q = self.spatial_body(body), self.coordinates(body)
        if found.turns == 4:
            return matrix_of(q[found.moves : found.moves + 4])
        if found.turns == 1:
            return matrix_of(quaternion_of(q[found.moves] * found.unit_axis))
        return np.eye(3)

    def place(self, body: str, points: np.ndarray) -> np.ndarray:
        """Global places of points (n, 3) given in the axes of a flexible body's reduced model, r + A u."""
        found = self.spatial_body(body)
        assert isinstance(found, SpatialFlexible)
        origin = self.coordinates(body)[:3] if found.moves else np.array(found.position)
        axes = self.rotation(body) @ (np.eye(3) if found.turns == 4 else found.placement)
        return np.real(origin + points @ axes.T)

    def position(self, body: str, point: str) -> np.ndarray:
        """Position (3,) of a named point of the scene, as carried by the body: r + A (z0 + Z c)."""
        body = self.scene.piece(body, point)
        marker, c = self._marker(body, point)
        return self._carried(body, np.real(marker.point[:3] + c @ marker.shape[:, :3]), np.real(marker.point[12:15]))

    def turned(self, body: str, point: str, axes: np.ndarray) -> np.ndarray:
        """Directions (3, n), columns, of the undeformed configuration that turn with the body at a point: A R(T c) e."""
        body = self.scene.piece(body, point)
        marker, c = self._marker(body, point, axes)
        return (
            self.rotation(body)
            @ matrix_of(quaternion_of(np.real(c @ marker.shape[:, 3:])))
            @ np.real(marker.point[3:12]).reshape(3, 3).T
        )

    def across(self, joint: AtPoints, side: int) -> np.ndarray:
        """First two axes of the joint, turned with the body."""
        axes = joint.axes if isinstance(joint, SpatialJoint) and joint.axes is not None else np.eye(3)
        return self.turned(*joint.grips[side], np.real(axes))[:, :2].T

    def centre(self, body: str) -> np.ndarray:
        """Centre of mass of a rigid body, (3,)."""
        found = self.spatial_body(body)
        assert isinstance(found, SpatialRigidBody)
        origin, middle = np.real(found.frame_origin(self.scene)), np.real(found.mass_properties(self.scene)[1])
        if not found.frame_size:
            return middle
        return self._carried(body, middle - origin, 0 * origin if found.moves else origin)

    def has_ball(self, body: str) -> bool:
        """Whether a ball is drawn for the centre of mass of a body."""
        found = self.spatial_body(body)
        return isinstance(found, SpatialRigidBody) and not isinstance(found, SpatialRod) and bool(self.segments(body))

    def frame(self, body: str) -> tuple[np.ndarray, np.ndarray]:
        """Origin (3,) and axes (3, 3), as columns, of the body's frame."""
        found = self.spatial_body(body)
        if isinstance(found, SpatialFlexible):
            origin, *ends = self.place(body, np.vstack([np.zeros(3), np.eye(3)]))
            return origin, np.array(ends).T - origin[:, None]
        return self.centre(body), self.rotation(body)

    def segments(self, body: str) -> list[np.ndarray]:
        """Lines (2, 3) that a rigid body is drawn as: along a rod, else from the centre of mass to every gripped point.

        A body that is gripped nowhere else is shown by the edges of the uniform box that has its mass and inertia, a flexible body
        without a surface by lines from the middle of its interface points to each.
        """
        found = self.spatial_body(body)
        if isinstance(found, SpatialFlexible):
            return self._interface_star(body, found)
        if not isinstance(found, SpatialRigidBody):
            return []
        if isinstance(found, SpatialRod):
            return [np.array([self.position(body, point) for point in found.between])]
        centre, points = self.centre(body), [*self.grips(), *((body, point) for point in found.named_points())]
        ends = [self.position(name, point) for name, point in dict.fromkeys(points) if name == body]
        arms = [
            np.array([centre, end]) for end in ends if np.linalg.norm(end - centre) > FAR * found.radius_of_gyration(self.scene)
        ]
        return arms or self._box(body, found)

    def _interface_star(self, body: str, found: SpatialFlexible) -> list[np.ndarray]:
        model, q = self.scene.model(found.model, "surface"), np.append(1.0, self.elastic(body))
        if model.surface is not None or not model.interfaces:
            return []
        points = self.place(body, np.array([point.here[0] @ q for point in model.interfaces.values()]))
        return [np.array([points.mean(axis=0), point]) for point in points]

    def _box(self, body: str, found: SpatialRigidBody) -> list[np.ndarray]:
        """Edges of a box along the principal axes, whose half sides are sqrt(3 s / m) for the second moments s."""
        mass, _, moments = found.mass_properties(self.scene)
        s, axes = np.linalg.eigh(np.real(moments))
        half, axes = np.sqrt(3 * s.clip(0) / np.real(mass)), self.rotation(body) @ axes
        corners = {signs: self.centre(body) + axes @ (half * signs) for signs in product((-1, 1), repeat=3)}
        pairs = [(a, b) for a in corners for b in corners if a < b and np.abs(np.subtract(a, b)).sum() == 2]
        return [np.array([corners[a], corners[b]]) for a, b in pairs]

    def _marker(self, body: str, point: str, axes: np.ndarray | None = None) -> tuple[SpatialMarkerNumbers, np.ndarray]:
        """Marker of a body at a point, and its coordinates c."""
        marker = self.spatial_body(body).marker(self.scene, point, body, axes)
        return marker, self.coordinates(body)[marker.columns]

    def _carried(self, body: str, local: np.ndarray, fixed: np.ndarray) -> np.ndarray:
        """Position r + A u, where r of a frame without an origin of its own is a fixed point."""
        origin = self.coordinates(body)[:3] if self.spatial_body(body).moves else fixed
        return origin + self.rotation(body) @ local


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


def stress_extremes(moment: SpatialConfiguration, body: str) -> tuple[float, float]:
    """Smallest and largest stress of fibres, or zero and the largest von Mises stress, of a body with a surface."""
    values = point_stress(body_shape(moment, body).stress)
    values = values[np.isfinite(values)]
    return float(values.min(initial=0)), float(values.max(initial=0))


def spatial_curves_figure(solution: Solution) -> Figure:
    """The curves, a panel per quantity."""
    moments = [SpatialConfiguration(solution, step) for step in range(len(solution.times))]
    moved = motion_panels(SpatialConfiguration.undeformed(solution).named_points(), moments)
    return draw_panels(solution, _stress_panels(solution, moments[0]) + moved + _rotation_panels(solution, moments))


def _stress_panels(solution: Solution, start: SpatialConfiguration) -> Panels:
    curves: dict[str, np.ndarray] = {}
    for body in (name for name in start.flexible() if has_shape(solution.system.scene, name)):
        low, high = stress_range(solution, body).T
        if body_shape(start, body).stress.shape[1] == 1:
            curves |= {f"{body}, largest": high, f"{body}, smallest": low}
        else:
            curves[f"{body}, largest von Mises"] = high
    return [("stress", "stress", curves)] if curves else []


def _rotation_panels(solution: Solution, moments: list[SpatialConfiguration]) -> Panels:
    """Angle by which every frame has turned about its main axis; whole turns count."""
    bodies = solution.system.scene.bodies.items()
    turning = [name for name, body in bodies if body.turns and not isinstance(body, CutBody)]
    curves = {name: counted_angle(np.array([moment.rotation(name) for moment in moments])) for name in turning}
    return [("rotation about\nown main axis", "angle", merged(curves))] if curves else []


def counted_angle(rotations: np.ndarray) -> np.ndarray:
    """Angles of frames (n, 3, 3), one after the other, about the fixed axis about which they turn most, (n,).

    The sum of all small turns phi_k (rotation vectors between neighbours) along the axis a that makes the sum of (phi_k . a)^2 largest,
    with the sign that makes the largest angle positive. A frame must turn by less than half a turn from one to the next.
    """
    small = Rotation.from_matrix(rotations[1:] @ np.swapaxes(rotations[:-1], 1, 2)).as_rotvec()
    axis = np.linalg.eigh(small.T @ small)[1][:, -1]
    angles = np.append(0.0, np.cumsum(small @ axis))
    return angles * (1.0 if angles.max() >= -angles.min() else -1.0)
