"""Matrices of isotropic elastic solids for unit moduli, their geometric stiffness, and their volume.

Matrices of isotropic elastic solids of any dimension d on the nodes of a mesh, for unit width, density and Lame's constants.

With scalar shape functions N_p, the component a of the displacement is S_a = [N_0 e_a, N_1 e_a, ...], so that all matrices are made of

    s_pq = int N_p N_q dV,    g^ab_pq = int dN_p/dx_a dN_q/dx_b dV

    M_ab = rho s in block (a, b)                                                                     theory section 1
    K    = lambda K_lambda + mu K_mu,   K_lambda = g^ab in block (a, b),   K_mu = g^ba + delta_ab sum_c g^cc in block (a, b)

Where the nodes move by V = N_k V_k per unit of a variable, the maps of the elements change by their gradients, and with them

    d(dN_p/dx_a) = -dV_c/dx_a dN_p/dx_c,    d(dV) = div V dV

Both are sums of one product of gradients and its transpose.

What the stress of a displacement adds to the stiffness of a solid.

    K_g = int sigma_ab d phi_p / dx_a d phi_q / dx_b dV   between the nodes p and q, the same for every component of the displacement

which is the work of the stress on the quadratic part of Green's strain (Zienkiewicz and Taylor, The Finite Element Method, vol. 2).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import fsum

import numpy as np
from scipy import sparse
from skfem import CellBasis

from preprocessing.elements.solid_elements import ElementBlock, points_of


@dataclass(frozen=True, eq=False)
class NodePairs:
    """Pairs of nodes in common elements, in the order of a sparse matrix by rows."""

    n_nodes: int
    starts: np.ndarray  # (n_nodes + 1,) of the rows
    columns: np.ndarray  # (n_pairs,)
    places: tuple[np.ndarray, ...]  # of each block, (n_e, n_local, n_local) numbers of the pairs of its elements

    def sums(self, places: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Sums (n_pairs, ...) of element values over the pairs; values (n_e, n_local, n_local, ...) belong to the places."""
        flat = values.reshape(places.size, -1)
        every = [np.bincount(places.ravel(), column, len(self.columns)) for column in flat.T]
        return np.stack(every, axis=-1).reshape(len(self.columns), *values.shape[3:])

    def matrix(self, values: np.ndarray) -> sparse.csr_array:
        """Sparse (n_nodes, n_nodes) of one value (n_pairs,) for each pair, or of blocks (n_pairs, d, d) between their components."""
        if values.ndim == 1:
            return sparse.csr_array((values, self.columns, self.starts), shape=(self.n_nodes,) * 2)
        n = self.n_nodes * values.shape[1]
        return sparse.bsr_array((values, self.columns, self.starts), shape=(n, n)).tocsr()


def node_pairs(blocks: Sequence[ElementBlock], n_nodes: int) -> NodePairs:
    """Pairs of nodes of all elements."""
    keys = [n_nodes * block.connectivity[:, :, None] + block.connectivity[:, None, :] for block in blocks]
    found, number = np.unique(np.concatenate([key.ravel() for key in keys]), return_inverse=True)
    starts = np.searchsorted(found, n_nodes * np.arange(n_nodes + 1))
    return NodePairs(n_nodes, starts.astype(np.int32), (found % n_nodes).astype(np.int32), tuple(_split(number, keys)))


def _split(number: np.ndarray, keys: Sequence[np.ndarray]) -> Iterator[np.ndarray]:
    ends = np.cumsum([key.size for key in keys])
    for key, end in zip(keys, ends, strict=True):
        yield number[end - key.size : end].astype(np.int32).reshape(key.shape)


@dataclass(frozen=True, eq=False)
class SolidMatrices:
    """Mass and stiffness matrices of a solid for unit parameters."""

    scalar_mass: sparse.csr_array  # s (n_nodes, n_nodes)
    first: sparse.csr_array  # K_lambda (n, n)
    shear: sparse.csr_array  # K_mu (n, n)


def solid_matrices(
    blocks: Sequence[ElementBlock], n_nodes: int, dimension: int, motion: np.ndarray | None = None
) -> SolidMatrices:
    """Assemble the matrices over all elements; with a motion of the nodes (n_nodes, d), their derivatives along it."""
    pairs = node_pairs(blocks, n_nodes)
    mass, gradients = np.zeros(len(pairs.columns)), np.zeros((len(pairs.columns), dimension, dimension))
    for block, places in zip(blocks, pairs.places, strict=True):
        for elements, functions in block.functions_in_parts():
            moved = None if motion is None else motion[block.connectivity[elements]]
            of_mass, of_gradients = _element_matrices(functions, moved)
            mass += pairs.sums(places[elements], of_mass)
            gradients += pairs.sums(places[elements], of_gradients)
    divergence = np.trace(gradients, axis1=1, axis2=2)
    shear = gradients.swapaxes(1, 2) + divergence[:, None, None] * np.eye(dimension)
    return SolidMatrices(pairs.matrix(mass), pairs.matrix(gradients), pairs.matrix(shear))


def in_block(scalar: sparse.csr_array, a: int, b: int, dimension: int) -> sparse.csr_array:
    """A sparse matrix (n_nodes, n_nodes) by rows between the components a and b of the displacement, (n, n)."""
    each = np.zeros((scalar.shape[0], dimension), scalar.indptr.dtype)
    each[:, a] = np.diff(scalar.indptr)
    starts = np.concatenate([each[:1, 0] * 0, np.cumsum(each, dtype=each.dtype)])
    n = dimension * scalar.shape[0]
    return sparse.csr_array((scalar.data, dimension * scalar.indices + b, starts), shape=(n, n))


def _element_matrices(functions: CellBasis, motion: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Matrices s_pq at [e, p, q] and g^ab_pq at [e, p, q, a, b] of some elements, or their rates.

    The rates are those as their nodes move (n_e, n_local, d).
    """
    values = np.stack([np.asarray(each[0])[0] for each in functions.basis])  # (n_local, n_points), the same in all elements
    gradients = np.stack([each[0].grad for each in functions.basis], axis=-1).transpose(1, 2, 3, 0)  # [e, point, p, a]
    weights, half = functions.dx, gradients / 2
    if motion is not None:
        slope = np.einsum("exka,ekc->exca", gradients, motion, optimize=True)  # dV_c/dx_a
        divergence = np.trace(slope, axis1=2, axis2=3)
        weights, half = weights * divergence, divergence[:, :, None, None] * half - gradients @ slope
    n_e, n_points, n_local, d = gradients.shape
    products = (values[:, None] * values[None]).reshape(-1, n_points)
    one = (functions.dx[:, :, None, None] * half).reshape(n_e, n_points, -1)
    both = one.swapaxes(1, 2) @ gradients.reshape(n_e, n_points, -1)
    both = (both + both.swapaxes(1, 2)).reshape(n_e, n_local, d, n_local, d)
    return (weights @ products.T).reshape(n_e, n_local, n_local), both.transpose(0, 1, 3, 2, 4)


@dataclass(frozen=True, eq=False)
class StressedSolid:
    """Elements of a solid, and Lame's constants for unit modulus; complex where a parameter made a complex step."""

    blocks: Sequence[ElementBlock]
    lame: tuple[complex, complex]  # lambda / E and mu / E
    motion: np.ndarray | None = (
        None  # (n_nodes, d), imaginary displacement of the nodes that is so small that its square vanishes
    )

    def stiffness(self, displacement: np.ndarray) -> sparse.csr_array:
        """Geometric stiffness K_g for unit modulus and width, sparse (n, n), of a displacement (n,), real or complex."""
        entries = [np.concatenate(each) for each in zip(*self._entries(displacement), strict=True)]
        d = self.blocks[0].geometry.p.shape[0]
        n = len(displacement) // d
        return sparse.kron(sparse.coo_array((entries[2], (entries[0], entries[1])), shape=(n, n)), np.eye(d), format="csr")

    def _entries(self, displacement: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Rows, columns and values of the elements, kind by kind and part by part."""
        for block in self.blocks:
            d = block.geometry.p.shape[0]
            for elements, functions in block.functions_in_parts():
                members = block.connectivity[elements]
                gradients, weights = self._measured(functions, members)
                stress = self._stress(gradients, displacement.reshape(-1, d)[members])
                value = np.einsum("exap,exac,excq,ex->epq", gradients, stress, gradients, weights, optimize=True)
                row, column = np.broadcast_arrays(members[:, :, None], members[:, None, :])
                yield row.ravel(), column.ravel(), value.ravel()

    def _measured(self, functions: CellBasis, members: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gradients of the shape functions (n_e, n_points, d, n_local) and weights of the points (n_e, n_points)."""
        gradients = np.stack([each[0].grad for each in functions.basis], axis=-1).transpose(1, 2, 0, 3)
        if self.motion is None:
            return gradients, functions.dx
        slope = np.einsum("exap,epc->exca", gradients, self.motion[members])  # dV_c / dx_a
        divergence = np.trace(slope, axis1=2, axis2=3)
        return gradients - 1j * np.einsum("exca,excp->exap", slope, gradients), functions.dx * (1 + 1j * divergence)

    def _stress(self, gradients: np.ndarray, moved: np.ndarray) -> np.ndarray:
        """Stress (n_e, n_points, d, d) of displacements (n_e, n_local, d)."""
        slope = np.einsum("exap,epc->exca", gradients, moved)
        strain = (slope + slope.swapaxes(2, 3)) / 2
        pressure = self.lame[0] * np.trace(strain, axis1=2, axis2=3)
        return pressure[:, :, None, None] * np.eye(strain.shape[2]) + 2 * self.lame[1] * strain


POINTS_AT_ONCE = 300_000
"""Points of integration at once."""


def volume_of(blocks: Iterable[ElementBlock]) -> float:
    """Volume of all elements, in the plane their area."""
    return fsum(_volume(block) for block in blocks)


def _volume(block: ElementBlock) -> float:
    """Integral of the determinant of each element's map over the reference element, without its sign."""
    points, weights = points_of(block.kind)
    mapping, at_once = block.geometry.mapping(), max(1, POINTS_AT_ONCE // len(weights))
    found = []
    for start in range(0, len(block.connectivity), at_once):
        elements = np.arange(start, min(start + at_once, len(block.connectivity)))
        found.append(float((np.abs(mapping.detDF(points, tind=elements)) * weights).sum()))
    return fsum(found)
