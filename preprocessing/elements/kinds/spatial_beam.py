"""Spatial beams of any section, on their nodal coordinates and the offset of `BeamElements`.

    M_ab = rho (A M_1 + S_2 M_2 + S_3 M_3),   K = E (A K_1 + B_2 K_2 + B_3 K_3) + G J K_4
    stress = E (eps - y_2 kappa_2 - y_3 kappa_3) at every fibre

with kappa G A (K_5 + K_6) besides where shear deforms them.

The offset is the one hidden coordinate: it has no stiffness and belongs to no displacement.
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
from preprocessing.elements.section_shape import ONE, SectionShape
from preprocessing.elements.space import SPACE
from toolkit.kinematics.beam_elements import BeamElements, length
from toolkit.reduced_model.model import StressPoints


@dataclass(frozen=True, eq=False)
class SpatialPatch:
    """Elements of one section that take their quantities from the same parameters; the factors may carry a complex step."""

    patch: Patch
    shape: SectionShape
    shear_factor: Any  # G / E = 1 / (2 (1 + nu))
    modulus_factor: Any = 1.0  # by which E is multiplied in stretching and bending: 1 / (1 - nu^2) in plane strain
    sheared: Sheared | None = None  # its numbers if shear deforms it

    @property
    def polynomials(self) -> SectionShape:
        """Of its section; numbers where shear deforms it."""
        return self.shape.fixed(self.sheared.dimensions) if self.sheared else self.shape

    @property
    def stepped(self) -> bool:
        """Whether a complex step of the section, or of Poisson's ratio, changes its elements."""
        own = self.sheared is not None and self.sheared.stepped
        return own or bool(np.imag(self.shear_factor) or np.imag(self.modulus_factor))


@dataclass(frozen=True, eq=False)
class SpatialBeam(LineElement):
    """Displacements along and rotations about x, y and z at both ends."""

    orientation: np.ndarray  # (n_e, 3), the e_3 of each section before it is made normal to its element
    patches: Sequence[SpatialPatch]

    space, per_node = SPACE, 6

    @property
    def hidden(self) -> int:
        """One coordinate for the offset of points from the centre line."""
        return 1

    @cached_property
    def axes(self) -> np.ndarray:
        """Unit vectors e_1, e_2, e_3 of every element as rows, (n_e, 3, 3)."""
        return BeamElements.in_space(self.ends, self.orientation).axes

    @cached_property
    def beams(self) -> BeamElements:
        """The elements that contribute."""
        own = self.contributing
        return BeamElements.in_space(self.ends[own], self.orientation[own], None if self.phi is None else self.phi[own])

    @cached_property
    def phi(self) -> np.ndarray | None:
        """Phi of deflections along e_2 and e_3 of every element, (n_e, 2); None without shear."""
        if not any(each.sheared for each in self.patches):
            return None
        lengths = length(self.ends)
        found = np.zeros((len(lengths), 2), complex)
        for each in self.patches:
            if each.sheared:
                k, at = each.patch.elements, each.shape.values(each.sheared.dimensions)
                moments = (each.modulus_factor * at[name] for name in ("bending_2", "bending_3"))
                found[k] = np.column_stack([each.sheared.phi(moment, at["area"], lengths[k]) for moment in moments])
        return found if np.any(found.imag) else found.real

    @cached_property
    def first_rows(self) -> np.ndarray:
        """Number of the first stress row of every element, and of all rows: fibre by fibre, of each its two ends, (n_e + 1,)."""
        count = np.zeros(len(self.connectivity), int)
        for each in self.patches:
            count[each.patch.elements] = 2 * len(each.shape.fibres)
        return np.concatenate([[0], np.cumsum(count)])

    @property
    def stress_points(self) -> StressPoints:
        """Element by element, fibre by fibre, of each its two ends."""
        fibres = {int(k): each.shape.fibres for each in self.patches for k in each.patch.elements}
        rows = [(k, end, fibre.side) for k in sorted(fibres) for fibre in fibres[k] for end in (0, 1)]
        return StressPoints(*np.array(rows).T)

    def functions(self, element: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        phi = None if self.phi is None else self.phi[[element]]
        own = BeamElements.in_space(self.ends[[element]], self.orientation[[element]], phi)
        return self.dofs[element, :-1], own.shape[0], own.rotation[0]

    def contributions(self) -> Iterator[Contribution]:
        for each in self.patches:
            elements, here = self.of_patch(each.patch)
            if len(elements):
                yield from self._inertial(each, elements, here)
                yield from self._elastic(each, elements, here)
                yield from self._stress(each, elements, here)

    def _inertial(self, each: SpatialPatch, elements: np.ndarray, here: np.ndarray) -> Iterator[Contribution]:
        shape, (second, third) = each.polynomials, self.beams.rotary_mass
        for terms, blocks in ((shape.area, self.beams.component_mass), (shape.spread_2, second), (shape.spread_3, third)):
            if terms:
                yield Contribution("mass", each.patch, terms, self.component_masses(elements, blocks[here]))

    def _elastic(self, each: SpatialPatch, elements: np.ndarray, here: np.ndarray) -> Iterator[Contribution]:
        shape, beams = each.polynomials, self.beams
        stiff = [
            (shape.area, each.modulus_factor, beams.stretching),
            (shape.bending_2, each.modulus_factor, beams.bending[0]),
            (shape.bending_3, each.modulus_factor, beams.bending[1]),
            (shape.torsion, each.shear_factor, beams.torsion),
        ]
        if each.sheared:
            stiff += [(shape.area, 1 / each.sheared.flexibility, rows) for rows in beams.shearing]
        for terms, factor, rows in stiff:
            yield squared(each.patch, terms, self.placed_rows(elements, np.sqrt(factor) * rows[here]))

    def _stress(self, each: SpatialPatch, elements: np.ndarray, here: np.ndarray) -> Iterator[Contribution]:
        """Strain and both curvatures at the ends of every fibre."""
        first, beams = self.first_rows, self.beams
        strain = np.repeat(beams.strain[here][:, None, :], 2, axis=1)
        rows = [each.modulus_factor * values for values in (strain, -beams.curvature[0][here], -beams.curvature[1][here])]
        for number, fibre in enumerate(each.polynomials.fibres):
            numbers = first[elements, None] + 2 * number + np.arange(2)
            for terms, blocks in zip((ONE, fibre.second, fibre.third), rows, strict=True):
                if terms:
                    yield Contribution("stress", each.patch, terms, self.placed_rows(elements, blocks, numbers, int(first[-1])))

    def section_terms(self) -> Iterator[SectionTerm]:
        for each in self.patches:
            patch, k, shape, factor = each.patch, each.patch.elements, each.shape, each.modulus_factor
            yield from section_terms("stress_per_strain", patch, k, ONE, factor, youngs_modulus=1)
            yield from section_terms("axial_stiffness", patch, k, shape.area, factor, youngs_modulus=1)
            for column, moment in enumerate((shape.bending_2, shape.bending_3)):
                yield from section_terms("bending_stiffness", patch, k, moment, factor, column, youngs_modulus=1)
            yield from section_terms("torsional_stiffness", patch, k, shape.torsion, each.shear_factor, youngs_modulus=1)
            if each.sheared:
                yield from section_terms("shear_stiffness", patch, k, shape.area, 1 / each.sheared.flexibility, youngs_modulus=1)
            yield from section_terms("mass_per_length", patch, k, shape.area, density=1)
            for number, fibre in enumerate(shape.fibres):
                rows = (self.first_rows[k, None] + 2 * number + np.arange(2)).ravel()
                for column, distance in enumerate((fibre.second, fibre.third)):
                    yield from section_terms("fibre_distance", patch, rows, distance, 1.0, column)

    @property
    def section_axes(self) -> np.ndarray:
        return self.orientation

    def tensions(self) -> Iterator[Tension]:
        """The normal force on the slopes of the centre line, and its stress on how the fibres of a section turn when it twists."""
        slopes, torsion = np.concatenate(self.beams.turning, axis=1), self.beams.torsion
        for each in self.patches:
            (elements, here), shape = self.of_patch(each.patch), each.polynomials
            for terms, rows in ((shape.area, slopes), (shape.bending_2, torsion), (shape.bending_3, torsion)):
                yield Tension(each.patch, elements, terms, each.modulus_factor * self.beams.strain[here], rows[here])

    def changing(self) -> SpatialBeam:
        found = self.stepped
        for each in self.patches:
            if each.stepped:
                found[each.patch.elements] = True
        return replace(self, wanted=np.flatnonzero(found))
