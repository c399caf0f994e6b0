"""Planar beams of a homogeneous rectangle: thickness t in the plane, width b across it.

    M_ab = rho b t M_1 + rho b t^3 / 12 M_3,   K = E b t K_1 + E b t^3 / 12 K_3
    stress = E (eps + f kappa t / 2),   f = +1 outer fibre, -1 inner fibre

with E times `modulus_factor`. M_3, the rotary inertia of the section, is there where it is asked for. It needs the offset of
`BeamElements` as the one hidden coordinate, which has no stiffness and belongs to no displacement. Shear adds kappa G b t K_2
where it deforms the beams.

The skin runs from F round the nose to G, anticlockwise, so its outside lies to the right of the direction of travel, at n = -t/2 in
the axes of the beam (n = direction turned by +90 degrees). There the strain eps - n kappa is eps + kappa t / 2: a skin that is bent
more strongly round the nose (kappa > 0) is in tension outside. `eps` and `kappa` are changes from the undeformed shape, which is free
of stress.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from preprocessing.elements.block_element import LineElement, Tension, section_terms
from preprocessing.elements.element import Contribution, squared
from preprocessing.elements.section import Patch, SectionTerm, Sheared
from preprocessing.elements.section_shape import ONE, Term, Terms, fixed, value_of
from preprocessing.elements.space import PLANE
from toolkit.kinematics.beam_elements import BeamElements, length
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
    sheared: Sequence[Sheared] = ()  # the numbers of every patch if shear deforms them

    space, per_node = PLANE, 3

    @property
    def hidden(self) -> int:
        """One coordinate for the offset of points from the centre line, where the section has rotary inertia."""
        return int(self.rotary_inertia)

    @cached_property
    def phi(self) -> np.ndarray | None:
        """Phi of every element, (n_e,); None without shear."""
        if not self.sheared:
            return None
        lengths = length(self.ends)
        found = np.zeros(len(lengths), complex)
        for patch, each in zip(self.patches, self.sheared, strict=True):
            moment, area = (value_of(terms, each.dimensions) for terms in (SECOND_MOMENT, AREA))
            found[patch.elements] = each.phi(self.modulus_factor * moment, area, lengths[patch.elements])
        return found if np.any(found.imag) else found.real

    @cached_property
    def beams(self) -> BeamElements:
        """The elements that contribute."""
        own = self.contributing
        return BeamElements.in_plane(self.ends[own], None if self.phi is None else self.phi[own])

    def contributions(self) -> Iterator[Contribution]:
        masses, stiff, stressed = self._masses(), self._stiff(), self._stressed()
        for number, patch in enumerate(self.patches):
            elements, here = self.of_patch(patch)
            if not len(elements):
                continue
            for terms, blocks in masses:
                yield Contribution("mass", patch, self._fixed(number, terms), self.component_masses(elements, blocks[here]))
            for terms, rows in stiff:
                yield squared(patch, self._fixed(number, terms), self.placed_rows(elements, rows[here]))
            if self.phi is not None:
                rows = self.beams.shearing[0][here] / np.sqrt(self.sheared[number].flexibility)
                yield squared(patch, self._fixed(number, AREA), self.placed_rows(elements, rows))
            numbers, n_rows = 4 * elements[:, None] + np.arange(4), 4 * len(self.connectivity)
            for terms, rows in stressed:
                placed = self.placed_rows(elements, rows[here], numbers, n_rows)
                yield Contribution("stress", patch, self._fixed(number, terms), placed)

    def _fixed(self, number: int, terms: Terms) -> Terms:
        """Polynomial of the section of a patch, a number where shear deforms it."""
        return fixed(terms, self.sheared[number].dimensions) if self.sheared else terms

    def _masses(self) -> list[tuple[Terms, np.ndarray]]:
        """Polynomials of the section and the component mass matrices that they multiply."""
        along = (AREA, self.beams.component_mass)
        return [along, (SECOND_MOMENT, self.beams.rotary_mass[0])] if self.rotary_inertia else [along]

    def _stiff(self) -> list[tuple[Terms, np.ndarray]]:
        """The same of the rows of the stiffness in stretching and bending."""
        root = np.sqrt(self.modulus_factor)
        return [(AREA, root * self.beams.stretching), (SECOND_MOMENT, root * self.beams.bending[0])]

    def _stressed(self) -> list[tuple[Terms, np.ndarray]]:
        """The same of the rows of the stress: of eps, and of f kappa / 2."""
        rows = self.beams.curvature[0][:, :, None, :] * FIBRES[:, None] / 2
        bent = rows.reshape(len(rows), 4, -1)
        return [
            (ONE, self.modulus_factor * np.repeat(self.beams.strain[:, None, :], 4, axis=1)),
            (THICKNESS, self.modulus_factor * bent),
        ]

    def section_terms(self) -> Iterator[SectionTerm]:
        for number, patch in enumerate(self.patches):
            k, factor = patch.elements, self.modulus_factor
            yield from section_terms("stress_per_strain", patch, k, ONE, factor, youngs_modulus=1)
            yield from section_terms("axial_stiffness", patch, k, AREA, factor, youngs_modulus=1)
            yield from section_terms("bending_stiffness", patch, k, SECOND_MOMENT, factor, youngs_modulus=1)
            yield from section_terms("mass_per_length", patch, k, AREA, density=1)
            if self.sheared:
                yield from section_terms(
                    "shear_stiffness", patch, k, AREA, 1 / self.sheared[number].flexibility, youngs_modulus=1
                )
            for place, fibre in enumerate(np.tile(FIBRES, 2)):
                yield from section_terms("fibre_distance", patch, 4 * k + place, THICKNESS, -fibre / 2)

    def tensions(self) -> Iterator[Tension]:
        """The normal force on the slopes."""
        strain, slopes = self.modulus_factor * self.beams.strain, self.beams.turning[0]
        for number, patch in enumerate(self.patches):
            elements, here = self.of_patch(patch)
            yield Tension(patch, elements, self._fixed(number, AREA), strain[here], slopes[here])

    def changing(self) -> PlanarBeam:
        found = self.stepped
        for patch, each in zip(self.patches, self.sheared, strict=False):
            found[patch.elements] |= each.stepped
        return self if np.imag(self.modulus_factor) else replace(self, wanted=np.flatnonzero(found))

    @property
    def stress_points(self) -> StressPoints:
        """For every element its ends 0 and 1, at each end the fibres +1 and -1."""
        element, end, fibre = np.meshgrid(np.arange(len(self.connectivity)), [0, 1], FIBRES, indexing="ij")
        return StressPoints(element.ravel(), end.ravel(), fibre.ravel())

    def functions(self, element: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        own = BeamElements.in_plane(self.ends[[element]], None if self.phi is None else self.phi[[element]])
        return self.dofs[element, : 2 * self.per_node], own.shape[0], own.rotation[0]
