"""Beam elements of the plane behind a body, read back from its mesh and its stress operator.

With the deformations a, psi, phi of `element_sections`, the exact ones of an element whose chord turns with it are, to second order,

    elongation  a + L psi^2 / 2,    rotations against the chord  phi_i + psi a / L

A deflection w against the body's axes makes the element shorter by half of

    int w'^2 dx = L psi^2 + L / 30 phi^T [4 -1; -1 4] phi        (the cubic deflection of an Euler-Bernoulli element)

so that its axial force N adds N times this form to the stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from toolkit.reduced_model.chord_condition import chord_of
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.model import MEAN_AXES
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.chord_rows import chord_rows
from toolkit.validity.bodies.chains.element_sections import Elements, Sections, sections
from toolkit.validity.bodies.chains.second_order import Forms, clamped_rows, mean_rows

SHORTENING = np.array([[4.0, -1.0], [-1.0, 4.0]]) / 30
"""int w'^2 dx / L of a cubic deflection against the chord, by the rotations of the ends."""


@dataclass(frozen=True, eq=False)
class PlanarChain(Chain):
    """Elements of rectangular sections in the plane."""

    elements: Elements
    made_of: Sections

    per_node: ClassVar[int] = 3

    @property
    def nodes(self) -> np.ndarray:
        return self.elements.nodes

    def make_forms(self) -> Forms:
        return planar_forms(self.elements, self.made_of)

    def make_stiffening(self) -> np.ndarray:
        """Of the axial force alone."""
        rows, length = self.elements.rows(), self.elements.lengths[:, None, None]
        bow = np.einsum("eip,ij,ejq->epq", rows[:, 2:], SHORTENING, rows[:, 2:])
        return (rows[:, 1, :, None] * rows[:, 1, None, :] / length + length * bow)[:, None]


def planar_forms(elements: Elements, made_of: Sections) -> Forms:
    """Elongation, and the rotations of both ends against the chord."""
    rows, lengths = elements.rows(), elements.lengths
    elongation, psi = rows[:, 0], rows[:, 1] / lengths[:, None]
    law = np.zeros((len(rows), 3, 3))
    law[:, 0, 0] = made_of.axial / lengths
    law[:, 1:, 1:] = (made_of.bending / lengths)[:, None, None] * made_of.law
    curved = np.zeros((len(rows), 3, 6, 6))
    curved[:, 0] = lengths[:, None, None] * psi[:, :, None] * psi[:, None, :]
    both = elongation[:, :, None] * psi[:, None, :] / lengths[:, None, None]
    curved[:, 1:] = (both + np.swapaxes(both, 1, 2))[:, None]
    return Forms(3 * len(elements.nodes), elements.dofs, rows[:, [0, 2, 3]], law, curved)


def planar_chain(design: DesignPoint) -> PlanarChain | None:
    """The elements of a reduced model in the plane; None where it does not hold its mesh and stress points."""
    mesh, places = design.model.mesh, design.model.stress
    if mesh is None or places is None:
        return None
    modulus = next((value for name, value in design.model.nominal.items() if name.startswith("youngs_modulus")), 1.0)
    operator, stiffness = (np.real(design.value(item)) for item in ("stress_operator", "stiffness"))
    elements, shapes = Elements(mesh.nodes, mesh.connectivity), mesh.recovery[:, 1:]
    made_of = sections(mesh, places, operator, stiffness, modulus)
    return PlanarChain(shapes, _held(design.model, elements, shapes), elements, made_of)


def _held(model: Any, elements: Elements, shapes: np.ndarray) -> np.ndarray:
    """Rows of displacements that the reference condition keeps at zero."""
    if model.reference_condition == MEAN_AXES:
        return mean_rows(elements.nodes, elements.connectivity)
    if chord := chord_of(model.reference_condition):
        return chord_rows(elements, *((model.interfaces or {})[name].position[0, :, 0] for name in chord))
    return clamped_rows(shapes, PlanarChain.per_node)
