"""The finite elements behind a body of a scene, if its reduced model tells them: by its mesh in the plane, by its elements in space.

Deformations to second order of straight beam elements in space that turn with their chords.

An element of length L and direction e, with displacements u_i and rotation vectors phi_i of its ends, has

    a = e . (u_2 - u_1)          its elongation
    c = e x (u_2 - u_1) / L      the turn of its chord
    r = e . (phi_1 + phi_2) / 2  the mean roll of its ends
    theta_i = phi_i - c - r e    rotations of its ends against axes that turn and roll so

The exact deformations of an element whose axes T = exp(psi) turn with it, exp(theta_i) = T^T exp(phi_i), are to second order

    a + L c^2 / 2,    theta_i + c a / L + r (e x c) / 2 - (c + r e) x theta_i / 2

but for a common roll of both ends, which no force resists. In the plane of e and one normal these are those of `planar_chain`.

Beam elements of the plane behind a body, of the sections that its reduced model keeps.

An element in the plane deforms as one in space (`spatial_forms`) that does not leave it: with its elongation a, the turn psi of its chord
and the rotations phi_i of its ends against the chord it has, to second order,

    elongation  a + L psi^2 / 2,    rotations against the chord  phi_i + psi a / L
    axial force  E A a / L,    end moments  E I / L ([4 2; 2 4] - 3 Phi / (1 + Phi) [1 1; 1 1]) phi,    Phi = 12 E I / (kappa G A L^2)

with Phi = 0 where shear does not deform it. A deflection w against the body's axes makes the element shorter by half of

    int w'^2 dx = L psi^2 + L / 30 phi^T [4 -1; -1 4] phi        (the cubic deflection of an Euler-Bernoulli element)

so that its axial force N adds N times this form to the stiffness.

Beam elements in space behind a body: those that its reduced model keeps one by one.

Forces s of the linear element do work on the second-order deformations d_2 = u^T Q u / 2 of `spatial_forms`, and so add sum_k s_k Q_k to
its stiffness: under bending moments and torques beams give way sideways, too. The axial force N does more of it where the element bows
between its ends,

    N L / 30 (4 theta_1^2 - 2 theta_1 theta_2 + 4 theta_2^2),    theta_i across the element

What bends a beam before it gives way turns its sections, which for bending about the stiffer principal axis leaves of the moment the part
1 - E I_weak / E I_strong (Trahair, Flexural-Torsional Buckling of Structures, 1993), and none for bending about the weaker: square bars and
tubes never buckle sideways.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from toolkit.components.bodies.framed_part import FramedPart, whole_design
from toolkit.foundation.kinematics.beam_elements import IN_PLANE
from toolkit.foundation.kinematics.orientation import axes_along, skew
from toolkit.reduced_model.cut_part import ChainPart
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.model import MEAN_AXES, Mesh, ReducedModel, chord_of
from toolkit.reduced_model.parts import BeamSections
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import flexible_body
from toolkit.validity.bodies.chain import Chain, Forms, chord_rows, clamped_rows, mean_rows, sides_of

DEFORMATIONS = 7
"""Number of deformations of an element: the elongation, and three rotations of each end."""
LEVI_CIVITA = -np.array([skew(axis) for axis in np.eye(3)])
"""Symbol of the cross product: (a x b)_c = sum_ij LEVI_CIVITA[c, i, j] a_i b_j."""


def spatial_forms(nodes: np.ndarray, connectivity: np.ndarray, stiffness: np.ndarray) -> Forms:
    """Deformations of elements in space with stiffness (n_e, 12, 12) on displacements and rotations x, y, z of both ends."""
    rows, curved = deformations(nodes, connectivity)
    e = rows[:, 0, 6:9]
    still = np.zeros((len(e), 12, DEFORMATIONS))  # a displacement of every deformation
    still[:, 6:9, 0], still[:, 3:6, 1:4], still[:, 9:, 4:] = e, np.eye(3), np.eye(3)
    law = np.swapaxes(still, 1, 2) @ stiffness @ still
    dofs = (6 * connectivity[:, :, None] + np.arange(6)).reshape(-1, 12)
    return Forms(6 * len(nodes), dofs, rows, law, curved)


def deformations(nodes: np.ndarray, connectivity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Elongation and end rotations of elements between nodes (n_nodes, 3): first order (n_e, 7, 12), and Q (n_e, 7, 12, 12)."""
    sides = nodes[connectivity[:, 1]] - nodes[connectivity[:, 0]]
    lengths = np.linalg.norm(sides, axis=1)
    e = sides / lengths[:, None]
    a, c, r, theta = _linear(e, lengths)
    rows = np.concatenate([a[:, None], theta.reshape(-1, 6, 12)], axis=1)
    return rows, np.concatenate([_stretch(c, lengths)[:, None], _rotations(e, lengths, a, c, r, theta)], axis=1)


def _linear(e: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Linear forms of a (n_e, 12), c (n_e, 3, 12), r (n_e, 12) and theta (n_e, 2, 3, 12)."""
    a, c, r, theta = (np.zeros((len(e), *shape, 12)) for shape in ((), (3,), (), (2, 3)))
    for end, sign in ((0, -1), (1, 1)):
        moves, turns = slice(6 * end, 6 * end + 3), slice(6 * end + 3, 6 * end + 6)
        a[:, moves], r[:, turns] = sign * e, e / 2
        c[:, :, moves] = sign * np.array([skew(each) for each in e]) / lengths[:, None, None]
        theta[:, end, :, turns] = np.eye(3)
    theta -= (c + e[:, :, None] * r[:, None])[:, None]
    return a, c, r, theta


def _stretch(c: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    return lengths[:, None, None] * (np.swapaxes(c, 1, 2) @ c)


def _rotations(e: np.ndarray, lengths: np.ndarray, a: np.ndarray, c: np.ndarray, r: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Second-order forms Q of the rotations of both ends, (n_e, 6, 12, 12)."""
    across = np.cross(e[:, :, None], c, axis=1)
    turn = c + e[:, :, None] * r[:, None]
    common = a[:, None, :, None] * c[:, :, None] / lengths[:, None, None, None] + r[:, None, :, None] * across[:, :, None] / 2
    crossed = np.einsum("cij,eip,enjq->encpq", LEVI_CIVITA, turn, theta, optimize=True)
    found = (common[:, None] - crossed / 2).reshape(-1, 6, 12, 12)
    return found + np.swapaxes(found, 2, 3)


SHORTENING = np.array([[4.0, -1.0], [-1.0, 4.0]]) / 30
"""int w'^2 dx / L of a cubic deflection against the chord, by the rotations of the ends."""
BENDING = np.array([[4.0, 2.0], [2.0, 4.0]])
"""Moments at both ends, times L / EI, per rotation of the ends against the chord."""
OF_PLANE = [0, 3, 6]
"""Numbers of a planar element's deformations among those in space: the elongation, and rotations of both ends about z."""


@dataclass(frozen=True, eq=False)
class PlanarChain(Chain):
    """A chain of beam elements of any section in the plane."""

    places: np.ndarray  # (n_nodes, 2)
    connectivity: np.ndarray  # (n_e, 2)
    made_of: BeamSections

    per_node: ClassVar[int] = 3

    @property
    def nodes(self) -> np.ndarray:
        return self.places

    def make_forms(self) -> Forms:
        return planar_forms(self.places, self.connectivity, self.made_of)

    def make_stiffening(self) -> np.ndarray:
        """Forms of the geometric stiffness by the axial force alone, (n_e, 1, p, p)."""
        phi, lengths = self.forms.rows[:, 1:], sides_of(self).lengths
        bow = np.einsum("eip,ij,ejq->epq", phi, SHORTENING, phi)
        return self.forms.curved[:, :1] + (lengths[:, None, None] * bow)[:, None]


def planar_forms(nodes: np.ndarray, connectivity: np.ndarray, made_of: BeamSections) -> Forms:
    """Elongation, and rotations of both ends against the chord, of elements between nodes (n_nodes, 2)."""
    rows, curved = deformations(np.column_stack([nodes, np.zeros(len(nodes))]), connectivity)
    rows, curved = rows[:, OF_PLANE][:, :, IN_PLANE], curved[:, OF_PLANE][:, :, IN_PLANE][..., IN_PLANE]
    dofs = (3 * connectivity[:, :, None] + np.arange(3)).reshape(-1, 6)
    lengths = np.linalg.norm(nodes[connectivity[:, 1]] - nodes[connectivity[:, 0]], axis=1)
    return Forms(3 * len(nodes), dofs, rows, planar_law(made_of, lengths), curved)


def planar_law(made_of: BeamSections, lengths: np.ndarray) -> np.ndarray:
    """Axial force and moments at both ends by elongation and rotations against the chord, (n_e, 3, 3)."""
    bending, shear = made_of.bending_stiffness[:, 0], made_of.shear_stiffness
    phi = np.divide(12 * bending, shear * lengths**2, out=np.zeros(len(lengths)), where=shear > 0)
    law = np.zeros((len(lengths), 3, 3))
    law[:, 0, 0] = made_of.axial_stiffness / lengths
    law[:, 1:, 1:] = (bending / lengths)[:, None, None] * (BENDING - 3 * (phi / (1 + phi))[:, None, None])
    return law


def planar_chain(design: DesignPoint) -> PlanarChain | None:
    """The elements of a reduced model in the plane; None where it does not hold its mesh and its sections."""
    mesh, made_of = design.model.mesh, design.sections()
    if mesh is None or made_of is None:
        return None
    shapes = mesh.recovery[:, 1:]
    held = _held(design.model, mesh, shapes)
    return PlanarChain(shapes, held, mesh.nodes, mesh.connectivity, made_of.real)


def _held(model: ReducedModel, mesh: Mesh, shapes: np.ndarray) -> np.ndarray:
    """Rows of displacements that the reference condition keeps at zero."""
    nodes, connectivity = mesh.nodes, mesh.connectivity
    if model.reference_condition == MEAN_AXES:
        return mean_rows(nodes, connectivity)
    if chord := chord_of(model.reference_condition):
        return chord_rows(nodes, connectivity, *((model.interfaces or {})[name].position[0, :, 0] for name in chord))
    return clamped_rows(shapes, PlanarChain.per_node)


@dataclass(frozen=True, eq=False)
class SpatialChain(Chain):
    """A chain of beam elements of any section in space."""

    places: np.ndarray  # (n_nodes, 3)
    connectivity: np.ndarray  # (n_e, 2)
    stiffness: np.ndarray  # (n_e, 12, 12)

    per_node: ClassVar[int] = 6

    @property
    def nodes(self) -> np.ndarray:
        return self.places

    def make_forms(self) -> Forms:
        return spatial_forms(self.places, self.connectivity, self.stiffness)

    def make_stiffening(self) -> np.ndarray:
        """Forms of the geometric stiffness by all forces of the elements, (n_e, 7, 12, 12)."""
        found, (e, lengths) = self.forms.curved.copy(), self._sides
        moments = found[:, 1:].reshape(-1, 2, 3, 12, 12)
        found[:, 1:] = np.einsum("ecd,encpq->endpq", self._counting(), moments, optimize=True).reshape(-1, 6, 12, 12)
        theta = self.forms.rows[:, 1:].reshape(-1, 2, 3, 12)
        across = theta - e[:, None, :, None] * np.einsum("ec,encp->enp", e, theta)[:, :, None]
        found[:, 0] += lengths[:, None, None] * np.einsum("encp,nm,emcq->epq", across, SHORTENING, across, optimize=True)
        return found

    def _counting(self) -> np.ndarray:
        """Part of the moments at an end that makes the element buckle sideways, (n_e, 3, 3).

        That is the torque, and bending about the stiffer axis.
        """
        law, e = self.forms.law, self._sides[0]
        along = e[:, :, None] * e[:, None, :]
        aside = np.eye(3) - along
        bending = aside @ (law[:, 1:4, 1:4] - law[:, 1:4, 4:]) @ aside  # 2 E I / L about every axis across
        values, axes = np.linalg.eigh(bending)
        strong, part = axes[:, :, 2], 1 - values[:, 1] / values[:, 2]
        return along + part[:, None, None] * strong[:, :, None] * strong[:, None, :]

    @cached_property
    def _sides(self) -> tuple[np.ndarray, np.ndarray]:
        """Directions (n_e, 3) and lengths (n_e,) of the elements."""
        sides = self.places[self.connectivity[:, 1]] - self.places[self.connectivity[:, 0]]
        lengths = np.linalg.norm(sides, axis=1)
        return sides / lengths[:, None], lengths


def rows_of_part(nodes: np.ndarray) -> np.ndarray:
    """Rows (6, n) of displacements that the frame of a part does not feel.

    The frame starts at its first node, goes through its last and rolls with both.
    """
    side, n = nodes[-1] - nodes[0], 6 * len(nodes)
    found, chord = np.zeros((6, n)), side / np.linalg.norm(side)
    found[:3, :3] = np.eye(3)
    found[3:5, n - 6 : n - 3] = axes_along(chord)[:, :2].T
    found[5, 3:6] = found[5, n - 3 :] = chord
    return found


SECTIONS = ("sections", "section_derivatives", "section_affine")
"""Parts of a reduced model that tell what its beams are made of, at every design."""


def has_chain(scene: ResolvedScene, body: str) -> bool:
    """Whether the reduced model of a flexible body holds the finite elements behind it."""
    return chain(scene, body) is not None


def chain(scene: ResolvedScene, body: str) -> Chain | None:
    """The finite elements behind a flexible body at the scene's parameter values; None if its reduced model does not hold them.

    Those of solids do not, nor those of reduced beams in space.
    """
    return _FINDERS[scene.dimension](scene, body)


def _in_plane(scene: ResolvedScene, body: str) -> Chain | None:
    written = flexible_body(scene, body)
    if isinstance(written, FramedPart):
        return _of_part(scene, written)
    design = written.design_point(scene, "mesh", "interfaces", *SECTIONS)
    if Chain not in design.kept:
        design.kept[Chain] = planar_chain(design)
    found: Chain | None = design.kept[Chain]
    return found


def _in_space(scene: ResolvedScene, body: str) -> Chain | None:
    written = flexible_body(scene, body)
    if isinstance(written, FramedPart):
        return _of_part(scene, written)
    design = written.design_point(scene, "elements", "element_derivatives", "element_affine")
    elements, shapes = design.model.elements, design.model.nodal_shapes
    if elements is None or shapes is None:
        return None
    if Chain not in design.kept:
        places, stiffness = (np.real(design.value(f"elements.{name}")) for name in ("nodes", "stiffness"))
        held = clamped_rows(shapes, SpatialChain.per_node)
        design.kept[Chain] = SpatialChain(shapes, held, places, elements.connectivity, stiffness)
    found: Chain = design.kept[Chain]
    return found


def _of_part(scene: ResolvedScene, written: FramedPart) -> Chain | None:
    """Elements of a part of a cut body, numbered from its first node."""
    design, part = whole_design(scene, written.whole), written.part(scene)
    key = (Chain, *written.own)
    if key not in design.kept:
        design.kept[key] = _CHAINS[scene.dimension](scene, written, part)
    found: Chain | None = design.kept[key]
    return found


def _spatial_part(scene: ResolvedScene, written: FramedPart, part: ChainPart) -> Chain:
    stiffness = np.real(whole_design(scene, written.whole).value("elements.stiffness"))
    nodes = np.real(part.nodes)
    rows, own = rows_of_part(nodes), stiffness[part.first : part.last]
    return SpatialChain(np.real(part.recovery[:, 1:]), rows, nodes, _one_by_one(part), own)


def _planar_part(scene: ResolvedScene, written: FramedPart, part: ChainPart) -> Chain | None:
    made_of = flexible_body(scene, written.whole).design_point(scene, *SECTIONS).sections()
    if made_of is None:
        return None
    nodes, connectivity = np.real(part.nodes), _one_by_one(part)
    rows, own = chord_rows(nodes, connectivity, nodes[0], nodes[-1]), made_of.of_elements(part.first, part.last).real
    return PlanarChain(np.real(part.recovery[:, 1:]), rows, nodes, connectivity, own)


def _one_by_one(part: ChainPart) -> np.ndarray:
    """First and second node of every element of a part, (n_e, 2)."""
    first = np.arange(part.last - part.first)
    return np.column_stack([first, first + 1])


_CHAINS: Mapping[int, Callable[[ResolvedScene, FramedPart, ChainPart], Chain | None]] = {2: _planar_part, 3: _spatial_part}
_FINDERS: Mapping[int, Callable[[ResolvedScene, str], Chain | None]] = {2: _in_plane, 3: _in_space}
"""By the dimension of space."""
