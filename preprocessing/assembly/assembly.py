"""Sparse matrices of the whole skin on its nodal coordinates, at one design and their derivatives by the section's parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from preprocessing.elements import beam, stress
from preprocessing.elements.section import Monomial, Patch, monomial, monomial_derivative
from preprocessing.mesh.curve_mesh import CurveMesh


@dataclass(frozen=True)
class Matrices:
    """Finite-element matrices on the n nodal coordinates, theory section 1; M_21 is the transpose of M_12."""

    m_11: Any  # sparse (n, n)
    m_12: Any  # sparse (n, n)
    m_22: Any  # sparse (n, n)
    stiffness: Any  # sparse (n, n)
    damping: Any  # sparse (n, n)
    stress: Any  # sparse (n_stress, n)

    @property
    def mass(self) -> Any:
        """M = M_11 + M_22."""
        return self.m_11 + self.m_22


class Root(NamedTuple):
    """Rows F with weight F^T F = K: of shapes psi that hardly strain stiff elements, F psi keeps the digits that K psi loses."""

    weight: float
    rows: Any  # sparse (n_rows, n)


class Part(NamedTuple):
    """One summand of one of the matrices, for unit parameters."""

    factors: Monomial
    name: str  # of the matrix
    matrix: Any  # sparse
    root: Root | None = None  # of a stiffness, where it is known


@dataclass(frozen=True)
class Parts:
    """The matrices as polynomials of the parameters: each is the sum of its parts times their monomials.

    In the plane they are `Matrices`; those of spatial bodies are `spatial_invariants.SpatialParts`.
    """

    parts: tuple[Part, ...]
    n: int  # nodal coordinates
    n_stress: int  # rows of the stress

    def at(self, values: Mapping[str, Any]) -> Any:
        """Matrices at one design."""
        return self._sum([(part, monomial(values, part.factors)) for part in self.parts])

    def derivative(self, values: Mapping[str, Any], parameter: str) -> Any:
        """Analytical derivative of the matrices by one parameter."""
        concerned = [part for part in self.parts if parameter in dict(part.factors)]
        return self._sum([(part, monomial_derivative(values, part.factors, parameter)) for part in concerned])

    def matrices(self, one: Callable[[str], Any]) -> Any:
        """The matrices, each by its name."""
        return Matrices(**{f.name: one(f.name) for f in fields(Matrices)})

    def _sum(self, weighted: list[tuple[Part, Any]]) -> Any:
        def one(name: str) -> Any:
            terms = [weight * part.matrix for part, weight in weighted if part.name == name and weight != 0]
            return _added(terms, self.n_stress if name == "stress" else self.n, self.n)

        return self.matrices(one)


def assemble(mesh: CurveMesh, patches: Iterable[Patch], modulus_factor: Any = 1.0) -> Parts:
    """Parts of the matrices; what depends on geometry only stands here, what depends on the section in the monomials.

    With thickness t, width b, and the modulus E times `modulus_factor` (1, or 1 / (1 - nu^2) in plane strain):

        M_ab = rho b t (...),   K = E b t K_1 + E b t^3 K_3,   D = a M + c K,   stress = E (...) + E t (...)

    Parameters
    ----------
    mesh : nodes real, or complex for a complex step in the geometry
    """
    parts = tuple(part for patch in patches for part in _parts_of(mesh, patch, modulus_factor))
    return Parts(parts, 3 * len(mesh.nodes), 4 * len(mesh.connectivity))


def _parts_of(mesh: CurveMesh, patch: Patch, modulus_factor: Any) -> Iterator[Part]:
    ends, elements = mesh.ends[patch.elements], patch.elements
    mass = beam.component_mass(ends)
    m_11, m_12, m_22 = (_square(mesh, elements, mass[:, a, b]) for a, b in ((0, 0), (0, 1), (1, 1)))
    inertial = {"density": 1, "thickness": 1, "width": 1}
    for name, matrix in (("m_11", m_11), ("m_12", m_12), ("m_22", m_22)):
        yield Part(patch.monomial(**inertial), name, matrix)
    yield Part(patch.monomial(damping_mass=1, **inertial), "damping", m_11 + m_22)
    # A = b t, I = b t^3 / 12
    stiff = {
        1: (beam.stretching_stiffness(ends), beam.stretching(ends)),
        3: (beam.bending_stiffness(ends) / 12, beam.bending(ends) / np.sqrt(12)),
    }
    for power, (blocks, rows) in stiff.items():
        elastic, matrix = {"youngs_modulus": 1, "thickness": power, "width": 1}, _square(mesh, elements, modulus_factor * blocks)
        root = Root(1.0, _rows(mesh, elements, np.arange(len(elements)), np.sqrt(modulus_factor) * rows, len(elements)))
        yield Part(patch.monomial(**elastic), "stiffness", matrix, root)
        yield Part(patch.monomial(damping_stiffness=1, **elastic), "damping", matrix, root)
    n_elements, strained = len(mesh.connectivity), modulus_factor * stress.strain_rows(ends)
    yield Part(patch.monomial(youngs_modulus=1), "stress", _rows(mesh, elements, elements, strained, n_elements))
    curved = _rows(mesh, elements, elements, modulus_factor * stress.curvature_rows(ends), n_elements)
    yield Part(patch.monomial(youngs_modulus=1, thickness=1), "stress", curved)


def _added(terms: list[Any], n_rows: int, n: int) -> Any:
    """Sum of sparse matrices, by one conversion instead of one per term."""
    if not terms:
        return sparse.csr_array((n_rows, n))
    if len(terms) == 1:
        return terms[0].tocsr()
    every = [term.tocoo() for term in terms]
    row, column, value = (np.concatenate([getattr(term, name) for term in every]) for name in ("row", "col", "data"))
    return sparse.coo_array((value, (row, column)), shape=(n_rows, n)).tocsr()


def _square(mesh: CurveMesh, elements: np.ndarray, blocks: np.ndarray) -> Any:
    """Sum element blocks (n_e, 6, 6) into one sparse matrix."""
    dofs, n = mesh.dofs[elements], 3 * len(mesh.nodes)
    rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    return sparse.coo_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(n, n)).tocsr()


def _rows(mesh: CurveMesh, elements: np.ndarray, places: np.ndarray, blocks: np.ndarray, n_places: int) -> Any:
    """Place rows (n_e, k, 6) of elements in one sparse matrix with k rows for each of `n_places` places."""
    k = blocks.shape[1]
    n_rows, numbers = k * n_places, k * places[:, None] + np.arange(k)
    rows, columns = np.broadcast_arrays(numbers[:, :, None], mesh.dofs[elements][:, None, :])
    return sparse.coo_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(n_rows, 3 * len(mesh.nodes))).tocsr()
