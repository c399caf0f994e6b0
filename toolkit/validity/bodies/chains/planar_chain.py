"""Beam elements of the plane behind a body, of the sections that its reduced model keeps.

An element in the plane deforms as one in space (`spatial_forms`) that does not leave it: with its elongation a, the turn psi of its chord
and the rotations phi_i of its ends against the chord it has, to second order,

    elongation  a + L psi^2 / 2,    rotations against the chord  phi_i + psi a / L
    axial force  E A a / L,    end moments  E I / L ([4 2; 2 4] - 3 Phi / (1 + Phi) [1 1; 1 1]) phi,    Phi = 12 E I / (kappa G A L^2)

with Phi = 0 where shear does not deform it. A deflection w against the body's axes makes the element shorter by half of

    int w'^2 dx = L psi^2 + L / 30 phi^T [4 -1; -1 4] phi        (the cubic deflection of an Euler-Bernoulli element)

so that its axial force N adds N times this form to the stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from toolkit.kinematics.beam_elements import IN_PLANE
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.model import MEAN_AXES, chord_of
from toolkit.reduced_model.parts import BeamSections
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.chord_rows import chord_rows
from toolkit.validity.bodies.chains.second_order import Forms, clamped_rows, mean_rows
from toolkit.validity.bodies.chains.sides import sides_of
from toolkit.validity.bodies.chains.spatial_forms import deformations

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
    held = _held(design.model, shapes)
    return PlanarChain(shapes, held, mesh.nodes, mesh.connectivity, made_of.real)


def _held(model: Any, shapes: np.ndarray) -> np.ndarray:
    """Rows of displacements that the reference condition keeps at zero."""
    nodes, connectivity = model.mesh.nodes, model.mesh.connectivity
    if model.reference_condition == MEAN_AXES:
        return mean_rows(nodes, connectivity)
    if chord := chord_of(model.reference_condition):
        return chord_rows(nodes, connectivity, *((model.interfaces or {})[name].position[0, :, 0] for name in chord))
    return clamped_rows(shapes, PlanarChain.per_node)
