"""Spatial beams of any section, on their nodal coordinates and the offset of `elements.spatial_beam`.

    M_ab = rho (A M_1 + S_2 M_2 + S_3 M_3),   K = E (A K_1 + B_2 K_2 + B_3 K_3) + G J K_4
    stress = E (eps - y_2 kappa_2 - y_3 kappa_3) at every fibre

with kappa G A (K_5 + K_6) besides where shear deforms them.

The offset is the one hidden coordinate: it has no stiffness and belongs to no displacement.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from preprocessing.elements import spatial_beam
from preprocessing.elements.block_element import LineElement, Tension, section_terms
from preprocessing.elements.element import Contribution, squared
from preprocessing.elements.section import Patch, SectionTerm, Sheared
from preprocessing.elements.section_shape import ONE, SectionShape
from preprocessing.elements.space import SPACE
from preprocessing.elements.spatial_beam import SECOND, THIRD
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
        return spatial_beam.axes(self.ends, self.orientation)

    @cached_property
    def phi(self) -> np.ndarray | None:
        """Phi of deflections along e_2 and e_3 of every element, (n_e, 2); None without shear."""
        if not any(each.sheared for each in self.patches):
            return None
        lengths = spatial_beam.length(self.ends)
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
        ends, triad, phi = self.ends[[element]], self.axes[[element]], None if self.phi is None else self.phi[[element]]
        return self.dofs[element, :-1], spatial_beam.shape(ends, triad, phi)[0], spatial_beam.rotation(ends, triad, phi)[0]

    def contributions(self) -> Iterator[Contribution]:
        every = self.contributing
        formulas = _formulas(self.ends[every], self.axes[every], None if self.phi is None else self.phi[every])
        for each in self.patches:
            elements, here = self.of_patch(each.patch)
            if len(elements):
                own = _Formulas(*(values[here] for values in formulas))
                yield from self._inertial(each, elements, own)
                yield from self._elastic(each, elements, own)
                yield from self._stress(each, elements, own)

    def _inertial(self, each: SpatialPatch, elements: np.ndarray, own: _Formulas) -> Iterator[Contribution]:
        shape = each.polynomials
        for terms, blocks in ((shape.area, own.mass), (shape.spread_2, own.spread_2), (shape.spread_3, own.spread_3)):
            if terms:
                yield Contribution("mass", each.patch, terms, self.component_masses(elements, blocks))

    def _elastic(self, each: SpatialPatch, elements: np.ndarray, own: _Formulas) -> Iterator[Contribution]:
        shape = each.polynomials
        stiff = [
            (shape.area, each.modulus_factor, own.stretching),
            (shape.bending_2, each.modulus_factor, own.bending_2),
            (shape.bending_3, each.modulus_factor, own.bending_3),
            (shape.torsion, each.shear_factor, own.torsion),
        ]
        if each.sheared:
            stiff += [(shape.area, 1 / each.sheared.flexibility, rows) for rows in (own.shearing_2, own.shearing_3)]
        for terms, factor, rows in stiff:
            yield squared(each.patch, terms, self.placed_rows(elements, np.sqrt(factor) * rows))

    def _stress(self, each: SpatialPatch, elements: np.ndarray, own: _Formulas) -> Iterator[Contribution]:
        """Strain and both curvatures at the ends of every fibre."""
        first = self.first_rows
        rows = [each.modulus_factor * values for values in (own.strain, -own.curvature_2, -own.curvature_3)]
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
        strain, torsion = spatial_beam.strain(self.ends, self.axes), spatial_beam.torsion(self.ends, self.axes)
        bent = [spatial_beam.turning(self.ends, self.axes, axis, self.phi) for axis in (SECOND, THIRD)]
        slopes = np.concatenate(bent, axis=1)
        for each in self.patches:
            k, shape = each.patch.elements, each.polynomials
            for terms, rows in ((shape.area, slopes), (shape.bending_2, torsion), (shape.bending_3, torsion)):
                yield Tension(each.patch, k, terms, each.modulus_factor * strain[k], rows[k])

    def changing(self) -> SpatialBeam:
        found = self.stepped
        for each in self.patches:
            if each.stepped:
                found[each.patch.elements] = True
        return replace(self, wanted=np.flatnonzero(found))


class _Formulas(NamedTuple):
    """What `elements.spatial_beam` says of some elements, for unit parameters; their number is the first axis."""

    mass: np.ndarray
    spread_2: np.ndarray
    spread_3: np.ndarray
    stretching: np.ndarray
    bending_2: np.ndarray
    bending_3: np.ndarray
    torsion: np.ndarray
    strain: np.ndarray  # at both ends
    curvature_2: np.ndarray
    curvature_3: np.ndarray
    shearing_2: np.ndarray  # zero without shear
    shearing_3: np.ndarray


def _formulas(ends: np.ndarray, triad: np.ndarray, phi: np.ndarray | None) -> _Formulas:
    own = np.zeros((len(ends), 2)) if phi is None else phi
    return _Formulas(
        mass=spatial_beam.component_mass(ends, triad, phi),
        spread_2=spatial_beam.rotary_mass(ends, triad, SECOND, phi),
        spread_3=spatial_beam.rotary_mass(ends, triad, THIRD, phi),
        stretching=spatial_beam.stretching(ends, triad),
        bending_2=spatial_beam.bending(ends, triad, SECOND, phi),
        bending_3=spatial_beam.bending(ends, triad, THIRD, phi),
        torsion=spatial_beam.torsion(ends, triad),
        strain=np.repeat(spatial_beam.strain(ends, triad)[:, None, :], 2, axis=1),
        curvature_2=spatial_beam.curvature(ends, triad, SECOND, phi),
        curvature_3=spatial_beam.curvature(ends, triad, THIRD, phi),
        shearing_2=spatial_beam.shearing(ends, triad, SECOND, own),
        shearing_3=spatial_beam.shearing(ends, triad, THIRD, own),
    )
