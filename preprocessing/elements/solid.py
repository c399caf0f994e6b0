"""Isotropic elastic solids in the plane or in space, from elements or from finished matrices.

    M_ab = rho b s in block (a, b) + what concentrated masses add
    K = E b (lambda/E K_lambda + mu/E K_mu),   stress = E (lambda/E B_lambda + mu/E B_mu)

with the width b in the plane only, and the matrices of `elements.solids`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from preprocessing.elements.elasticity import SolidMatrices, StressedSolid, in_block
from preprocessing.elements.element import SPACES, Contribution, Coordinates, Element, Pair
from preprocessing.elements.section import ONE, Patch, Term, Terms, monomial
from preprocessing.elements.stress import Rows
from preprocessing.elements.uniform_material import refuse_supports, refuse_swapped, scalar_mass, without_constant
from preprocessing.mesh.solid_mesh import SolidMesh
from toolkit.foundation.errors import InputError

QUANTITIES = {
    "youngs_modulus": "stress", "density": "density", "width": "length", "stiffness_scale": "none", "mass_scale": "none",
    "poisson_ratio": "none", "damping_mass": "rate", "damping_stiffness": "time",
}  # fmt: skip
"""Parameters of solids, and what they are, for their units."""
MATERIAL = {name: name for name in ("youngs_modulus", "density", "width", "damping_mass", "damping_stiffness")}
SCALES = {**MATERIAL, "youngs_modulus": "stiffness_scale", "density": "mass_scale"}
"""Parameters of finished matrices of unknown material."""
OTHER_MASS = {**MATERIAL, "density": "mass_scale"}
"""Parameters of finished matrices whose mass is not that of their density alone."""
ALL = np.zeros(0, int)
"""The elements of a solid are not told apart."""


@dataclass(frozen=True, eq=False)
class Solid(Element):
    """Elastic solid with displacements along the axes at every node, and the same shape functions for each."""

    nodes: np.ndarray  # (n_nodes, d)
    scalar_mass: sparse.csr_array  # of one component of the displacement, (n_nodes, n_nodes)
    stiffness: sparse.csr_array  # (n, n)
    stress: sparse.csr_array  # (n_stress, n)
    parameters: Mapping[str, str]  # quantity -> name of the parameter
    across: Terms  # what stiffness, and mass of a density, grow with besides the material: the width in the plane
    stressed: StressedSolid | None = None  # None of finished matrices
    constant_mass: Mapping[Pair, sparse.csr_array] | None = (
        None  # (a, b) -> M_ab of concentrated masses, with a hidden coordinate, if there are any
    )

    @property
    def coordinates(self) -> Coordinates:
        n_nodes, dimension = self.nodes.shape
        return Coordinates(SPACES[dimension], n_nodes, dimension, 0 if self.constant_mass is None else 1)

    @property
    def components(self) -> int:
        return 6 if self.nodes.shape[1] == 3 else 1

    def contributions(self) -> Iterator[Contribution]:
        patch, space, n = Patch(ALL, self.parameters), self.coordinates.space, self.coordinates.n
        blocks = {(a, b): _widened(in_block(self.scalar_mass, a, b, space.dimension), n, n) for a, b in space.pairs}
        yield Contribution("mass", patch, ONE if self.parameters["density"] == "mass_scale" else self.across, blocks)
        if self.constant_mass is not None:
            yield Contribution("constant mass", patch, ONE, self.constant_mass)
        yield Contribution("stiffness", patch, self.across, _widened(self.stiffness, n, n))
        yield Contribution("stress", patch, ONE, _widened(self.stress, self.stress.shape[0], n))

    def geometric_stiffness(self, values: Mapping[str, complex], displacement: np.ndarray) -> sparse.csr_array:
        if self.stressed is None:
            raise InputError(
                "finished matrices do not tell how the stress of a spin stiffens the body: spin_stiffening needs a mesh and its "
                "elements. Leave the key out of [basis], or leave [matrices] out."
            )
        patch = Patch(ALL, self.parameters)
        ((number, powers),) = self.across
        nodal, n = self.coordinates.nodal, self.coordinates.n
        stiffness = _widened(self.stressed.stiffness(displacement[:nodal]), n, n)
        return number * monomial(values, patch.monomial(youngs_modulus=1, **powers)) * stiffness


def _widened(matrix: sparse.csr_array, n_rows: int, n_columns: int) -> sparse.csr_array:
    """A sparse matrix with zeros beyond its own rows and columns; itself if there are none."""
    if matrix.shape == (n_rows, n_columns):
        return matrix
    rows = matrix.tocsr()
    starts = np.append(rows.indptr, np.full(n_rows - rows.shape[0], rows.indptr[-1], rows.indptr.dtype))
    return sparse.csr_array((rows.data, rows.indices, starts), shape=(n_rows, n_columns))


def element_solid(
    nodes: np.ndarray,
    matrices: SolidMatrices,
    rows: Rows,
    lame: tuple[complex, complex],
    stressed: StressedSolid | None = None,
    constant_mass: Mapping[Pair, sparse.csr_array] | None = None,
) -> Solid:
    """Solid from its elements, or from what a parameter changes of them.

    Parameters
    ----------
    lame : lambda / E and mu / E
    """
    stiffness, stress = (lame[0] * first + lame[1] * shear for first, shear in ((matrices.first, matrices.shear), rows))
    return Solid(nodes, matrices.scalar_mass, stiffness, stress, MATERIAL, _width(nodes.shape[1]), stressed, constant_mass)


def _width(dimension: int) -> Terms:
    return (Term(1.0, {"width": 1}),) if dimension == 2 else ONE


def finished_solid(
    mesh: SolidMesh,
    mass: sparse.csr_array,
    stiffness: sparse.csr_array,
    stress: sparse.csr_array,
    made_with: Mapping[str, float],
    constant_mass: Mapping[Pair, sparse.csr_array] | None = None,
) -> Solid:
    """Solid from finished matrices, which are proportional to their own material's constants, or else to a scale.

    Parameters
    ----------
    constant_mass : that is part of the mass, and does not follow the density

    Raises
    ------
    InputError
        The matrices are not those of displacement-based elements, or of a body with supports, or lack the constant mass.
    """
    refuse_swapped(mesh, mass, stiffness)
    refuse_supports(mesh, stiffness)
    scalar = scalar_mass(mass, mesh.dimension)
    if not made_with:
        return Solid(mesh.nodes, scalar, stiffness, stress, SCALES, ONE)
    modulus, width = made_with["youngs_modulus"], made_with.get("width", 1.0)
    scaled = stiffness / (modulus * width), stress / modulus
    if "density" not in made_with:
        return Solid(mesh.nodes, scalar, *scaled, OTHER_MASS, _width(mesh.dimension))
    if constant_mass is not None:
        scalar = without_constant(scalar, constant_mass, mesh)
    return Solid(
        mesh.nodes, scalar / (made_with["density"] * width), *scaled, MATERIAL, _width(mesh.dimension), None, constant_mass
    )


def parameters_of(material: Mapping[str, float], damping: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    """Parameters by which the matrices are polynomials, and their nominal values; without a material they are scales."""
    yield from (material or {"stiffness_scale": 1.0, "mass_scale": 1.0}).items()
    yield from ((f"damping_{name}", value) for name, value in damping.items())
