"""A scene in the plane at one step of a solution: where its bodies and points are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from toolkit.components.bodies.cut_body import CutBody
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.framed_part import FramedPart
from toolkit.components.bodies.rigid import Rod
from toolkit.components.joints.joint import AtPoints
from toolkit.foundation.errors import InputError
from toolkit.foundation.kinematics.beam_elements import POWERS, BeamElements
from toolkit.foundation.kinematics.orientation import rotation
from toolkit.foundation.near_ties import first_largest
from toolkit.reduced_model.model import Mesh, Outline, ReducedModel
from toolkit.render.moment import Moment
from toolkit.responses.shape_error import whole_axes
from toolkit.responses.stress import point_stress, stress_components, stress_operator
from toolkit.system.solution import design_point, flexible_body


@dataclass(frozen=True)
class Configuration(Moment):
    """One step of a planar solution, for drawing."""

    def elastic(self, body: str) -> np.ndarray:
        """Elastic coordinates q_f of a flexible body, shape (n_f,)."""
        found = self.scene.body(body)
        if isinstance(found, CutBody):
            return self.coordinates(body)[found.elastic_places]
        return self.coordinates(body)[3 if found.has_frame else 0 :]

    def place(self, body: str, points: np.ndarray) -> np.ndarray:
        """Global places r + A(theta) u of points (n, 2) in a flexible body's frame; of a cut one in the axes of the whole."""
        found = self.scene.body(body)
        if isinstance(found, CutBody):
            place, turned, origin = whole_axes(self.scene, body, self.coordinates(body))
            return np.real(place + (points - origin) @ rotation(turned).T)
        if found.has_frame:
            x, y, angle = self.coordinates(body)[:3]
        else:
            (x, y), angle = (found.position, found.angle) if isinstance(found, Flexible) else ((0.0, 0.0), 0.0)
        return np.real(np.array([x, y]) + points @ rotation(angle).T)

    def position(self, body: str, point: str) -> np.ndarray:
        """Position (2,) of a named point of the scene: r + A(theta) (z0 + Z q), or z0 + Z q without a frame."""
        found, q = self.scene.body(body), self.coordinates(body)
        marker = found.marker(self.scene, point, body)
        local = np.real(marker.point[:2] + q[marker.columns] @ marker.shape[:, :2])
        frame = marker.columns[:3]
        return q[frame[:2]] + rotation(q[frame[2]]) @ local if found.has_frame else local

    def turned(self, body: str, point: str, direction: np.ndarray) -> np.ndarray:
        """Direction (2,) of the undeformed configuration, turned with the body at a point: by theta + t0 + T q."""
        q, marker = self.coordinates(body), self.scene.body(body).marker(self.scene, point, body)
        angle = np.real(marker.point[2] + q[marker.columns] @ marker.shape[:, 2])
        return rotation(angle + q[marker.columns[2]] if self.scene.body(body).has_frame else angle) @ direction

    def across(self, joint: AtPoints, side: int) -> np.ndarray:
        """Axes of the coordinates, turned with the body."""
        return np.array([self.turned(*joint.grips[side], direction) for direction in np.eye(2)])

    def segments(self, body: str) -> list[np.ndarray]:
        """Lines (n, 2) that a body is drawn as: along a rod, or from a rigid body's centre of mass to its gripped points.

        A flexible body with a mesh is drawn as it is, without lines; else it is its outline, or a line through its interface points.
        """
        found = self.scene.body(body)
        if isinstance(found, Flexible):
            return self._chain(body, found)
        if isinstance(found, Rod):
            return [np.array([self.position(body, point) for point in found.between])]
        centre = self.coordinates(body)[:2]
        return [np.array([centre, self.position(body, point)]) for name, point in self.grips() if name == body]

    def _chain(self, body: str, found: Flexible) -> list[np.ndarray]:
        model = self.scene.model(found.model, "interfaces", "mesh", "outline")
        if model.outline:
            return [self.place(body, line @ np.append(1.0, self.elastic(body))) for line in lines_of(model.outline)]
        points = sorted((model.interfaces or {}).values(), key=lambda point: float(point.arc_length))
        if model.mesh or len(points) < 2:
            return []
        q = np.append(1.0, self.elastic(body))
        return [self.place(body, np.array([point.at(float(point.arc_length))[0] @ q for point in points]))]


def lines_of(outline: Outline) -> list[np.ndarray]:
    """Positions (n, 2, 1 + n_f) along every line of edges that follow one another."""
    first, last = outline.edges[:, 0], outline.edges[:, 2]
    starts = np.flatnonzero(np.append(True, first[1:] != last[:-1]))
    pieces = np.split(outline.edges, starts[1:])
    chains = [np.append(piece[:, :2].ravel(), piece[-1, 2]) for piece in pieces]
    return [outline.position[chain[np.append(True, np.diff(chain) != 0)]] for chain in chains]


POINTS = 13
"""Points per element, both ends included."""


@dataclass(frozen=True)
class SkinShape:
    """Flexible body as drawn: per element `POINTS` points of its middle line, with outer normal and stress."""

    line: np.ndarray  # (n_e, POINTS, 2), global
    outward: np.ndarray  # (n_e, POINTS, 2), unit normals
    stress: np.ndarray  # (n_e, POINTS, 2), outer and inner fibre

    def fibres(self, thickness: float) -> np.ndarray:
        """Outer and inner fibre of a body of that thickness, shape (n_e, POINTS, 2 fibres, 2)."""
        offset = thickness / 2 * self.outward
        return np.stack([self.line + offset, self.line - offset], axis=2)


def skin_shape(configuration: Configuration, body: str) -> SkinShape | None:
    """Shape of a flexible body at one step; None if its reduced model has no mesh.

    The middle line is the smooth curve through the undeformed nodes plus the elements' own displacement,

        u(r) = e [(1 - r) u_1 + r u_2] + n [(1 - 3r^2 + 2r^3) v_1 + L (r - 2r^2 + r^3) th_1 + (3r^2 - 2r^3) v_2 + L (r^3 - r^2) th_2]

    with r in [0, 1], e along the straight element of length L, n = e turned by +90 degrees. The stress is linear along the
    element, as it is in a beam of cubic deflection, so its extremes are those of the stress operator. The outer side lies to the
    right of the direction of travel.
    """
    return configuration.once(("skin shape", body), lambda: _skin_shape(configuration, body))


def _skin_shape(configuration: Configuration, body: str) -> SkinShape | None:
    model = drawn_model(configuration, body)
    if model.mesh is None:
        return None
    lines, outward = np.zeros((2, len(model.mesh.connectivity), POINTS, 2))
    undeformed = _undeformed(model.mesh)
    for framed, own, nodal in _framed(configuration, body, model.mesh):
        found = _placed(configuration, framed, model.mesh, nodal, undeformed)
        lines[own], outward[own] = (each[own] for each in found)
    return SkinShape(lines, outward, _stress(configuration, body, model))


def _framed(configuration: Configuration, body: str, mesh: Mesh) -> Iterator[tuple[str, slice, np.ndarray]]:
    """Name, elements and nodal displacements and rotations (n_nodes, 3) of every body or part with a frame, in that frame."""
    found = configuration.scene.body(body)
    if not isinstance(found, CutBody):
        yield body, slice(None), (mesh.recovery[:, 1:] @ configuration.elastic(body)).reshape(-1, 3)
        return
    for name, (first, last) in zip(found.parts(body), pairwise(found.cuts), strict=True):
        nodal = np.zeros((len(mesh.nodes), 3))
        own = drawn_model(configuration, name).mesh
        assert own is not None
        nodes = np.append(mesh.connectivity[first:last, 0], mesh.connectivity[last - 1, 1])
        nodal[nodes] = (own.recovery[:, 1:] @ configuration.elastic(name)).reshape(-1, 3)
        yield name, slice(first, last), nodal


def _placed(
    configuration: Configuration, body: str, mesh: Mesh, nodal: np.ndarray, undeformed: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Middle line and normals (n_e, POINTS, 2) of all elements, if all were in one frame."""
    (line, tangent), (moved, turned) = undeformed, _displacement(mesh, nodal)
    c, s = np.cos(turned), np.sin(turned)
    t_x, t_y = tangent[..., 0], tangent[..., 1]
    outward = np.stack([c * t_y + s * t_x, s * t_y - c * t_x], axis=2)  # A(turned) (t_y, -t_x)
    at = configuration.place(body, np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    axes = (at[1:] - at[0]).T
    return at[0] + (line + moved) @ axes.T, outward @ axes.T


def drawn_model(configuration: Configuration, body: str) -> ReducedModel:
    """Reduced model of a flexible body with the parts that pictures need."""
    scene = configuration.scene
    found = flexible_body(scene, body)
    if isinstance(found, FramedPart):
        return found.design_point(scene).model
    return scene.model(found.model, "stress", "shape", "mesh")


def _undeformed(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Points and unit tangents (n_e, POINTS, 2) of the spline through the nodes by chord length.

    Beams that follow no airfoil are straight.
    """
    if not len(mesh.target_outline):
        start, side = mesh.nodes[mesh.connectivity[:, 0]], np.diff(mesh.nodes[mesh.connectivity], axis=1)
        tangent = side / np.linalg.norm(side, axis=2, keepdims=True)
        return start[:, None] + _ratios()[:, None] * side, np.repeat(tangent, len(_ratios()), axis=1)
    chain = np.append(mesh.connectivity[:, 0], mesh.connectivity[-1, 1])
    if np.any(mesh.connectivity[:, 1] != chain[1:]):
        raise InputError("only a body whose elements follow one another can be drawn; number its mesh from one end to the other.")
    nodes = mesh.nodes[chain]
    chord = np.append(0.0, np.cumsum(np.hypot(*np.diff(nodes, axis=0).T)))
    spline = CubicSpline(chord, nodes)
    place = chord[:-1, None] + np.diff(chord)[:, None] * _ratios()
    tangent = spline(place, 1)
    return spline(place), tangent / np.linalg.norm(tangent, axis=2, keepdims=True)


def _displacement(mesh: Mesh, nodal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacement u(r) (n_e, POINTS, 2) and rotation w'(r) / L (n_e, POINTS) from nodal displacements and rotations (n, 3)."""
    own, of_ends = BeamElements.in_plane(mesh.nodes[mesh.connectivity]), nodal[mesh.connectivity].reshape(-1, 6)
    powers = _ratios()[:, None] ** POWERS
    moved = np.einsum("rk,ekdp,ep->erd", powers, own.shape, of_ends, optimize=True)
    return moved, np.einsum("rk,ekp,ep->er", powers, own.rotation, of_ends, optimize=True)


def _stress(configuration: Configuration, body: str, model: ReducedModel) -> np.ndarray:
    """Stress of outer and inner fibre, (n_e, POINTS, 2)."""
    return fibre_values(model, np.real(stress_operator(configuration.scene, body)[:, 0]) @ configuration.elastic(body))


def fibre_values(model: ReducedModel, values: np.ndarray) -> np.ndarray:
    """Values at the stress points (n_s,) in outer and inner fibre, linear between the ends of every element, (n_e, POINTS, 2).

    They are nan if the model does not say where its stress points are.
    """
    n_elements = 0 if model.mesh is None else len(model.mesh.connectivity)
    ends = np.full((n_elements, 2, 2), np.nan)
    if model.stress is not None:
        ends[model.stress.element, model.stress.end, (1 - model.stress.fibre) // 2] = values
    r = _ratios()[:, None]
    return (1 - r) * ends[:, None, 0] + r * ends[:, None, 1]


def _ratios() -> np.ndarray:
    return np.linspace(0, 1, POINTS)


EDGE_POINTS = 5
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
    r = np.linspace(0, 1, EDGE_POINTS)[:, None]
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
