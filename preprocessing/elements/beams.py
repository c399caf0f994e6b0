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
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, NamedTuple, Self

import numpy as np
from scipy import sparse

from preprocessing.elements.element import (
    PLANE,
    SPACE,
    Blocks,
    Contribution,
    Coordinates,
    Element,
    ElementSpace,
    Pair,
    Places,
    squared,
    weighted_sum,
)
from preprocessing.elements.section import ONE, Fibre, Patch, SectionShape, SectionTerm, Sheared, Term, Terms, monomial
from toolkit.foundation.kinematics.beam_elements import BeamElements, length
from toolkit.reduced_model.model import StressPoints


@dataclass(frozen=True, eq=False)
class BlockElement(Element):
    """Elements with small blocks; a kind states its space, the coordinates of a node, and its contributions."""

    nodes: np.ndarray  # (n_nodes, d)
    connectivity: np.ndarray  # (n_e, nodes of one element)

    space: ClassVar[ElementSpace]
    per_node: ClassVar[int]

    @property
    def hidden(self) -> int:
        """Number of hidden coordinates, see `elements.element.Coordinates`."""
        return 0

    @property
    def coordinates(self) -> Coordinates:
        return Coordinates(self.space, len(self.nodes), self.per_node, self.hidden)

    @cached_property
    def ends(self) -> np.ndarray:
        """Positions of the nodes of every element, (n_e, nodes of one element, d)."""
        return self.nodes[self.connectivity]

    @cached_property
    def dofs(self) -> np.ndarray:
        """Numbers of the coordinates of every element, the hidden ones last, (n_e, n_local)."""
        own = (self.per_node * self.connectivity[:, :, None] + np.arange(self.per_node)).reshape(len(self.connectivity), -1)
        hidden = self.coordinates.nodal + np.arange(self.hidden)
        return np.column_stack([own, np.broadcast_to(hidden, (len(own), self.hidden))])

    def component_masses(self, elements: np.ndarray, blocks: np.ndarray) -> dict[Pair, Blocks]:
        """Component masses M_ab from the blocks (n_e, d, d, p, p) of some elements on their first p coordinates."""
        dofs, n = self.dofs[elements, : blocks.shape[-1]], self.coordinates.n
        places = Places(elements, dofs, dofs, (n, n))
        return {(a, b): Blocks(places, blocks[:, a, b]) for a, b in self.space.pairs}

    def placed_rows(self, elements: np.ndarray, blocks: np.ndarray, numbers: np.ndarray | None = None, n_rows: int = 0) -> Blocks:
        """Rows (n_e, k, p) of some elements: one after the other, or at the numbers (n_e, k) of `n_rows`."""
        if numbers is None:
            n_rows = blocks.shape[0] * blocks.shape[1]
            numbers = np.arange(n_rows).reshape(blocks.shape[:2])
        return Blocks(Places(elements, numbers, self.dofs[elements, : blocks.shape[2]], (n_rows, self.coordinates.n)), blocks)


def section_terms(
    name: str, patch: Patch, rows: np.ndarray, terms: Terms, factor: complex = 1.0, column: int = 0, **material: int
) -> Iterator[SectionTerm]:
    """Section terms of a polynomial, times a factor and powers of quantities of the material."""
    for number, powers in terms:
        yield SectionTerm(name, rows, column, patch.monomial(**material, **powers), factor * number)


class Tension(NamedTuple):
    """Stiffening of elements by tension: E p(section) times their strain times the squares of their slopes."""

    patch: Patch
    elements: np.ndarray  # (n_e,) their numbers
    terms: Terms  # of the polynomial p
    strain: np.ndarray  # (n_e, p) rows of the strain along the element
    slopes: np.ndarray  # (n_e, k, p) rows F whose squares sum up to the integral of the squares of the slopes


@dataclass(frozen=True, eq=False)
class LineElement(BlockElement):
    """Straight elements between two nodes, on which interface points lie.

    The nodes turn too: their coordinates are x, y and a rotation, in space the displacements along and the rotations about x, y and z.
    """

    wanted: np.ndarray | None = field(default=None, kw_only=True)
    """Numbers of the elements that contribute; None: all of them."""

    @property
    def contributing(self) -> np.ndarray:
        """Numbers of the elements that contribute, listed also where these are all."""
        return np.arange(len(self.connectivity)) if self.wanted is None else self.wanted

    def of_patch(self, patch: Patch) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of a patch's elements that contribute, and their places among all that do."""
        if self.wanted is None:
            return patch.elements, patch.elements
        here = np.flatnonzero(np.isin(self.wanted, patch.elements))
        return self.wanted[here], here

    @property
    def stepped(self) -> np.ndarray:
        """Which elements have a node that a complex step moves, (n_e,) truth values."""
        return np.any(np.imag(self.ends) != 0, axis=(1, 2))

    def tensions(self) -> Iterator[Tension]:
        """Stiffening of the elements by tension; a kind without this method has no geometric stiffness."""
        yield from ()

    def section_terms(self) -> Iterator[SectionTerm]:
        """Terms of the sections of all elements; none of a kind that consists of no beams."""
        yield from ()

    @property
    def section_axes(self) -> np.ndarray:
        """Axes e_3 of all sections before they are made normal to their elements, (n_e, 3); z in the plane."""
        return np.tile([0.0, 0.0, 1.0], (len(self.connectivity), 1))

    def geometric_stiffness(self, values: Mapping[str, complex], displacement: np.ndarray) -> sparse.csr_array:
        n, found = self.coordinates.n, list[tuple[complex, Blocks]]()
        for patch, elements, terms, strain, slopes in self.tensions():
            dofs = self.dofs[elements, : strain.shape[1]]
            stretched = np.einsum("ep,ep->e", strain, displacement[dofs])
            blocks = Blocks(
                Places(elements, dofs, dofs, (n, n)), np.einsum("e,ekp,ekq->epq", stretched, slopes, slopes, optimize=True)
            )
            found += [(number * monomial(values, patch.monomial(youngs_modulus=1, **powers)), blocks) for number, powers in terms]
        return weighted_sum(found, (n, n)) if found else super().geometric_stiffness(values, displacement)

    def changing(self) -> Self:
        """Elements of which only those contribute that a complex step changes; leaving all in is right, but slow."""
        return self

    @property
    @abstractmethod
    def stress_points(self) -> StressPoints:
        """Stress points, one to each row of the stress operator."""

    @abstractmethod
    def functions(self, element: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Numbers of one element's nodal coordinates (p,), and coefficients of r^k in displacement (4, d, p) and rotation.

        The rotation is (4, p) in the plane and (4, 3, p) in space.
        """


AREA: Terms = (Term(1.0, {"thickness": 1, "width": 1}),)
SECOND_MOMENT: Terms = (Term(1 / 12, {"thickness": 3, "width": 1}),)
SIDES = tuple(Fibre((Term(-side / 2, {"thickness": 1}),), (), side) for side in (1, -1))
"""The fibres of a rectangle in the plane: outer and inner."""


@dataclass(frozen=True, eq=False)
class BeamPatch:
    """Elements of one section that take their quantities from the same parameters; the factors may carry a complex step."""

    patch: Patch
    shape: SectionShape
    shear_factor: complex  # G / E = 1 / (2 (1 + nu)), of torsion
    modulus_factor: complex = 1.0  # by which E is multiplied in stretching and bending: 1 / (1 - nu^2) in plane strain
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
        stiff: list[tuple[Terms, complex, np.ndarray]] = [(shape.area, factor, beams.stretching)]
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
    modulus_factor: complex = 1.0  # 1, or 1 / (1 - nu^2) in plane strain; may carry a complex step
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
