"""Spatial beams of any section, on their nodal coordinates and the offset of `elements.spatial_beam`.

    M_ab = rho (A M_1 + S_2 M_2 + S_3 M_3),   K = E (A K_1 + B_2 K_2 + B_3 K_3) + G J K_4
    stress = E (eps - y_2 kappa_2 - y_3 kappa_3) at every fibre

The offset is the one hidden coordinate: it has no stiffness and belongs to no displacement.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from preprocessing.elements import spatial_beam
from preprocessing.elements.block_element import LineElement
from preprocessing.elements.element import Contribution, Coordinates, squared
from preprocessing.elements.section import Patch
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


@dataclass(frozen=True, eq=False)
class SpatialBeam(LineElement):
    """Displacements along and rotations about x, y and z at both ends."""

    orientation: np.ndarray  # (n_e, 3), the e_3 of each section before it is made normal to its element
    patches: Sequence[SpatialPatch]

    space, per_node, hidden = SPACE, 6, 1

    def apart(self) -> SpatialBeam:
        return SpatialBeamsApart(**vars(super().apart()))

    @property
    def axes(self) -> np.ndarray:
        """Unit vectors e_1, e_2, e_3 of every element as rows, (n_e, 3, 3)."""
        return spatial_beam.axes(self.ends, self.orientation)

    @property
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
        ends, triad = self.ends[[element]], self.axes[[element]]
        return self.dofs[element, :-1], spatial_beam.shape(ends, triad)[0], spatial_beam.rotation(ends, triad)[0]

    def contributions(self) -> Iterator[Contribution]:
        first = self.first_rows
        for each in self.patches:
            ends, triad = self.ends[each.patch.elements], self.axes[each.patch.elements]
            yield from self._inertial(each, ends, triad)
            yield from self._elastic(each, ends, triad)
            yield from self._stress(each, ends, triad, first)

    def _inertial(self, each: SpatialPatch, ends: np.ndarray, triad: np.ndarray) -> Iterator[Contribution]:
        shape, patch = each.shape, each.patch
        yield Contribution(
            "mass", patch, shape.area, self.component_masses(patch.elements, spatial_beam.component_mass(ends, triad))
        )
        for terms, axis in ((shape.spread_2, SECOND), (shape.spread_3, THIRD)):
            if terms:
                blocks = spatial_beam.rotary_mass(ends, triad, axis)
                yield Contribution("mass", patch, terms, self.component_masses(patch.elements, blocks))

    def _elastic(self, each: SpatialPatch, ends: np.ndarray, triad: np.ndarray) -> Iterator[Contribution]:
        shape = each.shape
        stiff = [
            (shape.area, each.modulus_factor, spatial_beam.stretching(ends, triad)),
            (shape.bending_2, each.modulus_factor, spatial_beam.bending(ends, triad, SECOND)),
            (shape.bending_3, each.modulus_factor, spatial_beam.bending(ends, triad, THIRD)),
            (shape.torsion, each.shear_factor, spatial_beam.torsion(ends, triad)),
        ]
        for terms, factor, rows in stiff:
            yield squared(each.patch, terms, self.placed_rows(each.patch.elements, np.sqrt(factor) * rows))

    def _stress(self, each: SpatialPatch, ends: np.ndarray, triad: np.ndarray, first: np.ndarray) -> Iterator[Contribution]:
        """Strain and both curvatures at the ends of every fibre."""
        elements = each.patch.elements
        stretched = np.repeat(spatial_beam.strain(ends, triad)[:, None, :], 2, axis=1)
        bent = [spatial_beam.curvature(ends, triad, axis) for axis in (SECOND, THIRD)]
        for number, fibre in enumerate(each.shape.fibres):
            numbers = first[elements, None] + 2 * number + np.arange(2)
            for terms, rows in ((ONE, stretched), (fibre.second, -bent[0]), (fibre.third, -bent[1])):
                if terms:
                    placed = self.placed_rows(elements, each.modulus_factor * rows, numbers, int(first[-1]))
                    yield Contribution("stress", each.patch, terms, placed)


@dataclass(frozen=True, eq=False)
class SpatialBeamsApart(SpatialBeam):
    """Beams that share no node, each with an offset of its own; the offsets follow one another as the elements do."""

    @property
    def coordinates(self) -> Coordinates:
        return Coordinates(self.space, len(self.nodes), self.per_node, len(self.connectivity))

    @property
    def dofs(self) -> np.ndarray:
        own = super().dofs[:, :-1]
        return np.column_stack([own, self.coordinates.nodal + np.arange(len(own))])
