"""The deformed shape of a flexible body between its nodes, and the stress in its fibres, from a reduced model's mesh."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.cut.framed_part import FramedPart
from toolkit.foundation.errors import InputError
from toolkit.kinematics.beam_elements import POWERS, BeamElements
from toolkit.reduced_model.model import Mesh, ReducedModel
from toolkit.render.plane.configuration import Configuration
from toolkit.responses.stress.stress import stress_operator
from toolkit.system.flexible_bodies import flexible_body

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
