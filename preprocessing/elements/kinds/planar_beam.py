"""Planar beams of a homogeneous rectangle: thickness t in the plane, width b across it.

    M_ab = rho b t M_1 + rho b t^3 / 12 M_3,   K = E b t K_1 + E b t^3 / 12 K_3
    stress = E (eps + f kappa t / 2),   f = +1 outer fibre, -1 inner fibre

with E times `modulus_factor`. M_3, the rotary inertia of the section, is there where it is asked for. It needs the offset of
`elements.spatial_beam` as the one hidden coordinate, which has no stiffness and belongs to no displacement.

The skin runs from F round the nose to G, anticlockwise, so its outside lies to the right of the direction of travel, at n = -t/2 in
the axes of the beam (n = direction turned by +90 degrees). There the strain eps - n kappa is eps + kappa t / 2: a skin that is bent
more strongly round the nose (kappa > 0) is in tension outside. `eps` and `kappa` are changes from the undeformed shape, which is free
of stress.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from preprocessing.elements import beam
from preprocessing.elements.block_element import LineElement, Tension
from preprocessing.elements.element import Contribution, squared
from preprocessing.elements.section import Patch
from preprocessing.elements.section_shape import ONE, Term, Terms
from preprocessing.elements.space import PLANE
from toolkit.reduced_model.model import StressPoints

FIBRES = np.array([1, -1])
AREA: Terms = (Term(1.0, {"thickness": 1, "width": 1}),)
SECOND_MOMENT: Terms = (Term(1 / 12, {"thickness": 3, "width": 1}),)
THICKNESS: Terms = (Term(1.0, {"thickness": 1}),)


@dataclass(frozen=True, eq=False)
class PlanarBeam(LineElement):
    """Displacements x, y and the rotation at both ends."""

    patches: Sequence[Patch]
    modulus_factor: Any = 1.0  # 1, or 1 / (1 - nu^2) in plane strain; may carry a complex step
    rotary_inertia: bool = False  # whether the mass of the section is spread over its thickness, or lies on the centre line

    space, per_node = PLANE, 3

    @property
    def hidden(self) -> int:
        """One coordinate for the offset of points from the centre line, where the section has rotary inertia."""
        return int(self.rotary_inertia)

    def contributions(self) -> Iterator[Contribution]:
        ends = self.ends[self.contributing]
        heavy, root = self._masses(ends), np.sqrt(self.modulus_factor)
        stiff = ((AREA, root * beam.stretching(ends)), (SECOND_MOMENT, root * beam.bending(ends)))
        stressed = ((ONE, self.modulus_factor * strain_rows(ends)), (THICKNESS, self.modulus_factor * curvature_rows(ends)))
        for patch in self.patches:
            elements, here = self.of_patch(patch)
            if not len(elements):
                continue
            for terms, blocks in heavy:
                yield Contribution("mass", patch, terms, self.component_masses(elements, blocks[here]))
            for terms, rows in stiff:
                yield squared(patch, terms, self.placed_rows(elements, rows[here]))
            numbers, n_rows = 4 * elements[:, None] + np.arange(4), 4 * len(self.connectivity)
            for terms, rows in stressed:
                yield Contribution("stress", patch, terms, self.placed_rows(elements, rows[here], numbers, n_rows))

    def _masses(self, ends: np.ndarray) -> list[tuple[Terms, np.ndarray]]:
        """Polynomials of the section and the component mass matrices that they multiply."""
        along = (AREA, beam.component_mass(ends))
        return [along, (SECOND_MOMENT, beam.rotary_mass(ends))] if self.rotary_inertia else [along]

    def tensions(self) -> Iterator[Tension]:
        """The normal force on the slopes."""
        strain, slopes = self.modulus_factor * beam.strain(self.ends), beam.turning(self.ends)
        for patch in self.patches:
            yield Tension(patch, patch.elements, AREA, strain[patch.elements], slopes[patch.elements])

    def changing(self) -> PlanarBeam:
        return self if np.imag(self.modulus_factor) else replace(self, wanted=np.flatnonzero(self.stepped))

    @property
    def stress_points(self) -> StressPoints:
        """For every element its ends 0 and 1, at each end the fibres +1 and -1."""
        element, end, fibre = np.meshgrid(np.arange(len(self.connectivity)), [0, 1], FIBRES, indexing="ij")
        return StressPoints(element.ravel(), end.ravel(), fibre.ravel())

    def functions(self, element: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        ends = self.ends[[element]]
        return self.dofs[element, : 2 * self.per_node], beam.shape(ends)[0], beam.rotation(ends)[0]


def strain_rows(ends: np.ndarray) -> np.ndarray:
    """Rows of eps at the stress points, to be multiplied by E; (n_e, 4, 6)."""
    return np.repeat(beam.strain(ends)[:, None, :], 4, axis=1)


def curvature_rows(ends: np.ndarray) -> np.ndarray:
    """Rows of f kappa / 2 at the stress points, to be multiplied by E t; (n_e, 4, 6)."""
    rows = beam.curvature(ends)[:, :, None, :] * FIBRES[:, None] / 2
    return rows.reshape(len(ends), 4, 6)
