"""Beams of any section in space, and of a homogeneous rectangle in the plane, on their nodal coordinates and the offset of `BeamElements`.

    M_ab = rho (A M_1 + S_2 M_2 + S_3 M_3),   K = E (A K_1 + B_2 K_2 + B_3 K_3) + G J K_4
    stress = E (eps - y_2 kappa_2 - y_3 kappa_3) at every fibre

with kappa G A (K_5 + K_6) besides where shear deforms them; in the plane without axis 3 and torsion. The offset is the one hidden
coordinate: it has no stiffness and belongs to no displacement.

A skin runs from F round the nose to G, anticlockwise, so its outside lies to the right of the direction of travel, at y_2 = -t/2. There
the strain eps - y_2 kappa is eps + kappa t / 2: a skin that is bent more strongly round the nose (kappa > 0) is in tension outside. `eps`
and `kappa` are changes from the undeformed shape, which is free of stress.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np

from preprocessing.elements.block_element import LineElement, Tension, section_terms
from preprocessing.elements.element import Contribution, squared
from preprocessing.elements.section import Patch, SectionTerm, Sheared
from preprocessing.elements.section_shape import ONE, Fibre, SectionShape, Term, Terms
from preprocessing.elements.space import PLANE, SPACE
from toolkit.kinematics.beam_elements import BeamElements, length
from toolkit.reduced_model.model import StressPoints

AREA: Terms = (Term(1.0, {"thickness": 1, "width": 1}),)
SECOND_MOMENT: Terms = (Term(1 / 12, {"thickness": 3, "width": 1}),)
SIDES = tuple(Fibre((Term(-side / 2, {"thickness": 1}),), (), side) for side in (1, -1))
"""The fibres of a rectangle in the plane: outer and inner."""


@dataclass(frozen=True, eq=False)
class BeamPatch:
    """Elements of one section that take their quantities from the same parameters; the factors may carry a complex step."""

    patch: Patch
    shape: SectionShape
    shear_factor: Any  # G / E = 1 / (2 (1 + nu)), of torsion
    modulus_factor: Any = 1.0  # by which E is multiplied in stretching and bending: 1 / (1 - nu^2) in plane strain
    sheared: Sheared | None = None  # its numbers if shear deforms it

    @property
    def polynomials(self) -> SectionShape:
        """Polynomials of the section of an element; numbers where shear deforms it."""
        return self.shape.fixed(self.sheared.dimensions) if self.sheared else self.shape

    @property
    def stepped(self) -> bool:
        """Whether a complex step of the section, or of Poisson's ratio, changes its elements."""
        own = self.sheared is not None and self.sheared.stepped
        return own or bool(np.imag(self.shear_factor) or np.imag(self.modulus_factor))


class Beam(LineElement):
    """Base of beams in the plane and in space; a kind states its sections and makes its `BeamElements`."""

    ends_first: ClassVar[bool]
    """Order of the stress points of an element: both ends of a fibre follow each other, or all fibres of an end."""

    @property
    @abstractmethod
    def sections(self) -> Sequence[BeamPatch]:
        """Sections of the beams, each with its elements."""

    @abstractmethod
    def elements(self, numbers: np.ndarray) -> BeamElements:
        """Beam elements with the given numbers."""

    @property
    def planes(self) -> int:
        """Number of planes in which the beams bend: one, or two in space."""
        return self.space.dimension - 1

    @cached_property
    def phi(self) -> np.ndarray | None:
        """Shear parameters Phi of deflections in every plane of every element, (n_e, planes); None without shear."""
        if not any(each.sheared for each in self.sections):
            return None
        lengths = length(self.ends)
        found = np.zeros((len(lengths), self.planes), complex)
        for each in self.sections:
            if each.sheared:
                k, at = each.patch.elements, each.shape.values(each.sheared.dimensions)
                moments = [each.modulus_factor * at[name] for name in ("bending_2", "bending_3")[: self.planes]]
                found[k] = np.column_stack([each.sheared.phi(moment, at["area"], lengths[k]) for moment in moments])
        return found if np.any(found.imag) else found.real

    @cached_property
    def first_rows(self) -> np.ndarray:
        """Number of the first stress row of every element, and of all rows, (n_e + 1,)."""
        count = np.zeros(len(self.connectivity), int)
        for each in self.sections:
            count[each.patch.elements] = 2 * len(each.shape.fibres)
        return np.concatenate([[0], np.cumsum(count)])

    @property
    def stress_points(self) -> StressPoints:
        """Stress points element by element, at both ends of every fibre."""
        found = np.zeros((3, int(self.first_rows[-1])), int)
        for each in self.sections:
            for number, fibre in enumerate(each.shape.fibres):
                rows = self._rows(each, each.patch.elements, number)
                found[0, rows], found[1, rows], found[2, rows] = each.patch.elements[:, None], [0, 1], fibre.side
        return StressPoints(*found)

    def _rows(self, each: BeamPatch, elements: np.ndarray, number: int) -> np.ndarray:
        """Numbers of the stress rows at both ends of one fibre of some elements, (n, 2)."""
        own = [number, len(each.shape.fibres) + number] if self.ends_first else [2 * number, 2 * number + 1]
        rows: np.ndarray = self.first_rows[elements, None] + own
        return rows

    def functions(self, element: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        own = self.elements(np.array([element]))
        return self.dofs[element, : 2 * self.per_node], own.shape[0], own.rotation[0]

    def contributions(self) -> Iterator[Contribution]:
        beams = self.elements(self.contributing)  # not kept: their blocks are as large as all that is made of them
        for each in self.sections:
            elements, here = self.of_patch(each.patch)
            if len(elements):
                yield from self._inertial(each, beams, elements, here)
                yield from self._elastic(each, beams, elements, here)
                yield from self._stress(each, beams, elements, here)

    def _inertial(self, each: BeamPatch, beams: BeamElements, elements: np.ndarray, here: np.ndarray) -> Iterator[Contribution]:
        shape = each.polynomials
        yield Contribution("mass", each.patch, shape.area, self.component_masses(elements, beams.component_mass[here]))
        for plane, terms in enumerate((shape.spread_2, shape.spread_3)):
            if terms:
                blocks = beams.rotary_mass[plane][here]
                yield Contribution("mass", each.patch, terms, self.component_masses(elements, blocks))

    def _elastic(self, each: BeamPatch, beams: BeamElements, elements: np.ndarray, here: np.ndarray) -> Iterator[Contribution]:
        shape, factor = each.polynomials, each.modulus_factor
        stiff: list[tuple[Terms, Any, np.ndarray]] = [(shape.area, factor, beams.stretching)]
        stiff += [(terms, factor, rows) for terms, rows in zip((shape.bending_2, shape.bending_3), beams.bending, strict=False)]
        if shape.torsion:
            stiff.append((shape.torsion, each.shear_factor, beams.torsion))
        if each.sheared:
            stiff += [(shape.area, 1 / each.sheared.flexibility, rows) for rows in beams.shearing]
        for terms, each_factor, rows in stiff:
            yield squared(each.patch, terms, self.placed_rows(elements, np.sqrt(each_factor) * rows[here]))

    def _stress(self, each: BeamPatch, beams: BeamElements, elements: np.ndarray, here: np.ndarray) -> Iterator[Contribution]:
        """Contributions to the stress: strain at all fibres, and the curvatures at both ends of each."""
        fibres, factor, count = each.polynomials.fibres, each.modulus_factor, int(self.first_rows[-1])
        every = self.first_rows[elements, None] + np.arange(2 * len(fibres))
        strain = factor * np.repeat(beams.strain[here][:, None, :], 2 * len(fibres), axis=1)
        yield Contribution("stress", each.patch, ONE, self.placed_rows(elements, strain, every, count))
        bent = [-factor * curvature[here] for curvature in beams.curvature]
        for number, fibre in enumerate(fibres):
            rows = self._rows(each, elements, number)
            for terms, blocks in zip((fibre.second, fibre.third), bent, strict=False):
                if terms:
                    yield Contribution("stress", each.patch, terms, self.placed_rows(elements, blocks, rows, count))

    def section_terms(self) -> Iterator[SectionTerm]:
        for each in self.sections:
            patch, k, shape, factor = each.patch, each.patch.elements, each.shape, each.modulus_factor
            yield from section_terms("stress_per_strain", patch, k, ONE, factor, youngs_modulus=1)
            yield from section_terms("axial_stiffness", patch, k, shape.area, factor, youngs_modulus=1)
            for column, moment in enumerate((shape.bending_2, shape.bending_3)[: self.planes]):
                yield from section_terms("bending_stiffness", patch, k, moment, factor, column, youngs_modulus=1)
            yield from section_terms("torsional_stiffness", patch, k, shape.torsion, each.shear_factor, youngs_modulus=1)
            if each.sheared:
                yield from section_terms("shear_stiffness", patch, k, shape.area, 1 / each.sheared.flexibility, youngs_modulus=1)
            yield from section_terms("mass_per_length", patch, k, shape.area, density=1)
            for number, fibre in enumerate(shape.fibres):
                rows = self._rows(each, k, number).ravel()
                for column, distance in enumerate((fibre.second, fibre.third)[: self.planes]):
                    yield from section_terms("fibre_distance", patch, rows, distance, 1.0, column)

    def tensions(self) -> Iterator[Tension]:
        """Stiffening by the normal force, on the slopes of the centre line; in space also on fibres that turn in torsion.

        Of those it is the stress of the normal force that acts on how they turn when the section twists.
        """
        beams = self.elements(self.contributing)
        slopes = np.concatenate(beams.turning, axis=1)
        for each in self.sections:
            (elements, here), shape = self.of_patch(each.patch), each.polynomials
            twisting = [(terms, beams.torsion) for terms in (shape.bending_2, shape.bending_3) if shape.torsion]
            for terms, rows in ((shape.area, slopes), *twisting):
                yield Tension(each.patch, elements, terms, each.modulus_factor * beams.strain[here], rows[here])

    def changing(self) -> Self:
        found = self.stepped
        for each in self.sections:
            if each.stepped:
                found[each.patch.elements] = True
        return replace(self, wanted=np.flatnonzero(found))


@dataclass(frozen=True, eq=False)
class SpatialBeam(Beam):
    """Spatial beams with displacements along and rotations about x, y and z at both ends."""

    orientation: np.ndarray  # (n_e, 3), the e_3 of each section before it is made normal to its element
    patches: Sequence[BeamPatch]

    space, per_node, ends_first = SPACE, 6, False

    @property
    def hidden(self) -> int:
        """Number of hidden coordinates: one for the offset of points from the centre line."""
        return 1

    @property
    def sections(self) -> Sequence[BeamPatch]:
        return self.patches

    @property
    def section_axes(self) -> np.ndarray:
        return self.orientation

    @cached_property
    def axes(self) -> np.ndarray:
        """Unit vectors e_1, e_2, e_3 of every element as rows, (n_e, 3, 3)."""
        return BeamElements.in_space(self.ends, self.orientation).axes

    def elements(self, numbers: np.ndarray) -> BeamElements:
        phi = None if self.phi is None else self.phi[numbers]
        return BeamElements.in_space(self.ends[numbers], self.orientation[numbers], phi)


@dataclass(frozen=True, eq=False)
class PlanarBeam(Beam):
    """Planar beams with displacements x, y and the rotation at both ends.

    Their sections are rectangles: thickness in the plane, width across it.
    """

    patches: Sequence[Patch]
    modulus_factor: Any = 1.0  # 1, or 1 / (1 - nu^2) in plane strain; may carry a complex step
    rotary_inertia: bool = False  # whether the mass of the section is spread over its thickness, or lies on the centre line
    sheared: Sequence[Sheared] = ()  # the numbers of every patch if shear deforms them

    space, per_node, ends_first = PLANE, 3, True

    @property
    def hidden(self) -> int:
        """Number of hidden coordinates: one for the offset of points from the centre line, where there is rotary inertia."""
        return int(self.rotary_inertia)

    @cached_property
    def sections(self) -> Sequence[BeamPatch]:
        shape = SectionShape(AREA, SECOND_MOMENT, (), SECOND_MOMENT if self.rotary_inertia else (), (), (), SIDES)
        sheared: Sequence[Sheared | None] = self.sheared or [None] * len(self.patches)
        return [
            BeamPatch(patch, shape, 0.0, self.modulus_factor, each) for patch, each in zip(self.patches, sheared, strict=True)
        ]

    def elements(self, numbers: np.ndarray) -> BeamElements:
        return BeamElements.in_plane(self.ends[numbers], None if self.phi is None else self.phi[numbers, 0])
