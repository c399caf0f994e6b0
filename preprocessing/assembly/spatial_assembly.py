"""Sparse matrices of spatial beams on their nodal coordinates and the offset, as polynomials of the parameters of their sections.

The last coordinate is the offset of `spatial_beam`: it has no stiffness and belongs to no displacement.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from preprocessing.assembly.assembly import Part, Root
from preprocessing.assembly.spatial_invariants import NAMES, SpatialParts
from preprocessing.elements import spatial_beam
from preprocessing.elements.section import Patch
from preprocessing.elements.section_shape import SectionShape, Term, Terms
from preprocessing.elements.spatial_beam import SECOND, THIRD
from toolkit.reduced_model.spatial_model import PAIRS

PER_NODE = 6
"""Coordinates of a node: displacements along x, y, z and rotations about them."""
ONE: Terms = (Term(1.0, {}),)


@dataclass(frozen=True, eq=False)
class BeamMesh:
    """Straight spatial beams between nodes; complex where a parameter made a complex step."""

    nodes: np.ndarray  # (n_nodes, 3)
    connectivity: np.ndarray  # (n_elements, 2)
    orientation: np.ndarray  # (n_elements, 3), the e_3 of each section before it is made normal to its element

    @property
    def n(self) -> int:
        """Number of nodal coordinates, without the offset."""
        return PER_NODE * len(self.nodes)

    @property
    def ends(self) -> np.ndarray:
        """Positions of the two ends of every element, (n_elements, 2, 3)."""
        return self.nodes[self.connectivity]

    @property
    def axes(self) -> np.ndarray:
        """Unit vectors e_1, e_2, e_3 of every element as rows, (n_elements, 3, 3)."""
        return spatial_beam.axes(self.ends, self.orientation)

    def functions(self, element: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Numbers of one element's nodal coordinates (12,), and coefficients of r^k in its displacement and rotation, both (4, 3, 12)."""
        ends, triad = self.ends[[element]], self.axes[[element]]
        return self.dofs[element, :-1], spatial_beam.shape(ends, triad)[0], spatial_beam.rotation(ends, triad)[0]

    @property
    def dofs(self) -> np.ndarray:
        """Numbers of the coordinates of every element, the offset last, (n_elements, 13)."""
        own = (PER_NODE * self.connectivity[:, :, None] + np.arange(PER_NODE)).reshape(-1, 2 * PER_NODE)
        return np.column_stack([own, np.full(len(own), self.n)])


@dataclass(frozen=True, eq=False)
class SpatialPatch:
    """Elements of one section that take their quantities from the same parameters; the factors may carry a complex step."""

    patch: Patch
    shape: SectionShape
    shear_factor: Any  # G / E = 1 / (2 (1 + nu))
    modulus_factor: Any = 1.0  # by which E is multiplied in stretching and bending: 1 / (1 - nu^2) in plane strain


def assemble(mesh: BeamMesh, patches: Iterable[SpatialPatch]) -> SpatialParts:
    """Parts of the matrices; what depends on geometry only stands here, what depends on the section in the monomials.

        M_ab = rho (A M_1 + S_2 M_2 + S_3 M_3),   K = E (A K_1 + B_2 K_2 + B_3 K_3) + G J K_4,   D = a M + c K
        stress = E (eps - y_2 kappa_2 - y_3 kappa_3) at every fibre

    Parameters
    ----------
    mesh : nodes real, or complex for a complex step in the geometry
    """
    patches = list(patches)
    first = first_rows(mesh, patches)
    parts = [part for each in patches for part in _parts_of(mesh, each)]
    parts += [part for each in patches for part in _stress(mesh, each, first)]
    return SpatialParts(tuple(parts), mesh.n + 1, int(first[-1]), 1)


def first_rows(mesh: BeamMesh, patches: Iterable[SpatialPatch]) -> np.ndarray:
    """Number of the first stress row of every element, and of all rows: fibre by fibre, of each its two ends, (n_elements + 1,)."""
    count = np.zeros(len(mesh.connectivity), int)
    for each in patches:
        count[each.patch.elements] = 2 * len(each.shape.fibres)
    return np.concatenate([[0], np.cumsum(count)])


def _parts_of(mesh: BeamMesh, each: SpatialPatch) -> Iterator[Part]:
    elements, shape, patch = each.patch.elements, each.shape, each.patch
    ends, triad = mesh.ends[elements], mesh.axes[elements]
    masses = [(shape.area, spatial_beam.component_mass(ends, triad))]
    masses += [(shape.spread_2, spatial_beam.rotary_mass(ends, triad, SECOND))] if shape.spread_2 else []
    masses += [(shape.spread_3, spatial_beam.rotary_mass(ends, triad, THIRD))] if shape.spread_3 else []
    for terms, blocks in masses:
        matrices = [_square(mesh, elements, blocks[:, a, b]) for a, b in PAIRS]
        for name, matrix in zip(NAMES, matrices, strict=True):
            yield from _summands(patch, terms, name, matrix, density=1)
        yield from _summands(patch, terms, "damping", matrices[0] + matrices[1] + matrices[2], damping_mass=1, density=1)
    stiff = [
        (shape.area, each.modulus_factor, spatial_beam.stretching(ends, triad)),
        (shape.bending_2, each.modulus_factor, spatial_beam.bending(ends, triad, SECOND)),
        (shape.bending_3, each.modulus_factor, spatial_beam.bending(ends, triad, THIRD)),
        (shape.torsion, each.shear_factor, spatial_beam.torsion(ends, triad)),
    ]
    for terms, factor, blocks in stiff:
        rows = np.arange(blocks.shape[0] * blocks.shape[1]).reshape(blocks.shape[:2])
        roots = _rows(mesh, elements, rows, np.sqrt(factor) * blocks, rows.size)
        matrix = (roots.T @ roots).tocsr()
        yield from _summands(patch, terms, "stiffness", matrix, roots, youngs_modulus=1)
        yield from _summands(patch, terms, "damping", matrix, roots, damping_stiffness=1, youngs_modulus=1)


def _summands(patch: Patch, terms: Terms, name: str, matrix: Any, roots: Any = None, **powers: int) -> Iterator[Part]:
    """One part for every term of a polynomial of the section, times powers of other quantities of the patch."""
    for number, dimensions in terms:
        root = None if roots is None else Root(number, roots)
        yield Part(patch.monomial(**powers, **dimensions), name, number * matrix, root)


def _stress(mesh: BeamMesh, each: SpatialPatch, first: np.ndarray) -> Iterator[Part]:
    """Strain and both curvatures at the ends of every fibre."""
    elements, shape = each.patch.elements, each.shape
    ends, triad = mesh.ends[elements], mesh.axes[elements]
    stretched = np.repeat(spatial_beam.strain(ends, triad)[:, None, :], 2, axis=1)
    bent = [spatial_beam.curvature(ends, triad, axis) for axis in (SECOND, THIRD)]
    for number, fibre in enumerate(shape.fibres):
        rows = first[elements, None] + 2 * number + np.arange(2)
        for terms, blocks in ((ONE, stretched), (fibre.second, -bent[0]), (fibre.third, -bent[1])):
            if terms:
                matrix = _rows(mesh, elements, rows, each.modulus_factor * blocks, int(first[-1]))
                yield from _summands(each.patch, terms, "stress", matrix, youngs_modulus=1)


def _square(mesh: BeamMesh, elements: np.ndarray, blocks: np.ndarray) -> Any:
    """Sum element blocks (n_e, 12, 12), or (n_e, 13, 13) with the offset, into one sparse matrix."""
    dofs = mesh.dofs[elements, : blocks.shape[1]]
    rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    return sparse.coo_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(mesh.n + 1, mesh.n + 1)).tocsr()


def _rows(mesh: BeamMesh, elements: np.ndarray, numbers: np.ndarray, blocks: np.ndarray, n_rows: int) -> Any:
    """Place element rows (n_e, k, 12) in one sparse matrix, at the row numbers (n_e, k)."""
    rows, columns = np.broadcast_arrays(numbers[:, :, None], mesh.dofs[elements, None, : blocks.shape[2]])
    return sparse.coo_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(n_rows, mesh.n + 1)).tocsr()
