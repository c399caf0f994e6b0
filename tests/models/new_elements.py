"""Two finite elements that the project does not have, each one record: what a new kind costs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from preprocessing.elements.beams import AREA, SECOND_MOMENT, BlockElement, LineElement
from preprocessing.elements.element import PLANE, Contribution, squared
from preprocessing.elements.section import ONE, Patch, Term
from toolkit.foundation.kinematics.beam_elements import AXIAL, BeamElements
from toolkit.reduced_model.model import StressPoints


@dataclass(frozen=True, eq=False)
class Bar(BlockElement):
    """Bars of a planar truss between hinges: x and y at both ends, linear along the bar, with an `area`."""

    patches: Sequence[Patch]

    space, per_node = PLANE, 2

    def contributions(self) -> Iterator[Contribution]:
        area, consistent, axes = (Term(1.0, {"area": 1}),), np.array([[2, 1], [1, 2]]) / 6, np.eye(2)
        for patch in self.patches:
            elements, ends = patch.elements, self.ends[patch.elements]
            own = BeamElements.in_plane(ends)
            length, along = own.lengths, own.axes[:, 0, :2]
            mass = np.einsum("e,pq,ai,bj->eabpiqj", length, consistent, axes, axes).reshape(-1, 2, 2, 4, 4)
            strain = (np.column_stack([-along, along]) / length[:, None])[:, None]
            yield Contribution("mass", patch, area, self.component_masses(elements, mass))
            yield squared(patch, area, self.placed_rows(elements, np.sqrt(length)[:, None, None] * strain))
            yield Contribution(
                "stress", patch, ONE, self.placed_rows(elements, strain, elements[:, None], len(self.connectivity))
            )


LINEAR = np.einsum("kp,ai->kapi", AXIAL, np.eye(3)).reshape(4, 3, 6)
"""Coefficients of r^k in displacements and rotation between two nodes, each linear in those of the nodes."""


@dataclass(frozen=True, eq=False)
class ShearBeam(LineElement):
    """Planar Timoshenko beams: displacements and rotation linear, the shear strain that of the middle, and rotary inertia.

    The hidden coordinate is that of `BeamElements`: the point at y across the beam is at ([S, 0] + [R, n] y) [u_e; 1].
    T. J. R. Hughes, R. L. Taylor and W. Kanoknukulchai, A simple and efficient finite element for plate bending (1977).
    """

    patches: Sequence[Patch]
    shear_factor: Any  # k G / E

    space, per_node, hidden = PLANE, 3, 1

    def contributions(self) -> Iterator[Contribution]:
        for patch in self.patches:
            elements, ends = patch.elements, self.ends[patch.elements]
            own = BeamElements.in_plane(ends)
            length, along, across = own.lengths[:, None, None], own.axes[:, 0, :2], own.axes[:, 1, :2]
            none = 0 * length[:, 0]
            stretched = np.column_stack([-along, none, along, none])[:, None] / length
            bent = np.column_stack([none, none, none - 1, none, none, none + 1])[:, None] / length
            sheared = np.column_stack([-across, -length[:, 0] / 2, across, -length[:, 0] / 2])[:, None] / length
            offset = np.concatenate([-along[:, None, :, None] * LINEAR[:, None, 2], np.zeros((len(ends), 4, 2, 1))], axis=3)
            offset[:, 0, :, 6] = across
            for terms, shapes in ((AREA, np.tile(LINEAR[:, :2], (len(ends), 1, 1, 1))), (SECOND_MOMENT, offset)):
                yield Contribution("mass", patch, terms, self.component_masses(elements, own.products(shapes)))
            stiff = ((AREA, 1, stretched), (SECOND_MOMENT, 1, bent), (AREA, self.shear_factor, sheared))
            for terms, factor, rows in stiff:
                yield squared(patch, terms, self.placed_rows(elements, np.sqrt(factor * length) * rows))
            numbers, n_rows = 2 * elements[:, None] + np.arange(2), 2 * len(self.connectivity)
            fibres = np.array([[1], [-1]]) / 2
            for terms, rows in ((ONE, stretched + 0 * fibres), ((Term(1.0, {"thickness": 1}),), fibres * bent)):
                yield Contribution("stress", patch, terms, self.placed_rows(elements, rows, numbers, n_rows))

    @property
    def stress_points(self) -> StressPoints:
        """Of every element the fibres +1 and -1, told at its first end."""
        n = len(self.connectivity)
        return StressPoints(np.repeat(np.arange(n), 2), np.zeros(2 * n, int), np.tile([1, -1], n))

    def functions(self, element: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self.dofs[element, :6], LINEAR[:, :2], LINEAR[:, 2]
