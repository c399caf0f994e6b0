"""Stress recovered from finite elements: a smooth field that is nearer to the true one than what it is made of.

Round every corner v of the elements a polynomial P_v is fitted to the stress of the elements that meet there, at points where it is most
exact (Zienkiewicz and Zhu, Int. J. Numer. Meth. Engng 33, 1331, 1992). Between the corners the polynomials are mixed by the shape
functions lambda_v of straight elements, which sum up to one:

    sigma*(x) = sum_v lambda_v(x) P_v(x)

A patch whose points leave a term open, as at the corner of a body, takes in the elements round it if these tell it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
import skfem
from scipy import sparse
from skfem.quadrature import get_quadrature

from preprocessing.elements.solids.elements import ElementBlock, wedge_points
from preprocessing.mesh.simplices import ALL_CORNERS

LINEAR = ("triangle", "quad", "tetra", "hexahedron", "wedge")
"""Kinds whose stress a linear polynomial is fitted to; of the others a quadratic one."""
SAMPLED = {"triangle6": 2, "quad8": 5, "quad9": 5, "tetra10": 2, "hexahedron20": 5, "hexahedron27": 5}
WEDGES = {"wedge": (1, 3), "wedge15": (2, 5)}
"""Order of the points that a kind is sampled at, of wedges across and along: one point of linear elements (of wedges two), three or four
of triangles and tetrahedra with middles of edges, and three in each direction of squares and cubes and along wedges: two could not tell a
quadratic polynomial across one layer."""
STRAIGHT = {
    "triangle": skfem.ElementTriP1, "quad": skfem.ElementQuad1, "tetra": skfem.ElementTetP1, "hexahedron": skfem.ElementHex1,
    "wedge": skfem.ElementWedge1,
}  # fmt: skip
"""Shape functions of the corners."""
ROUNDS = 3
"""Number of times that a patch may grow."""
UNTOLD = 1e-6
"""Part of the largest eigenvalue of a patch's normal matrix below which its points leave a term open."""


@dataclass(frozen=True, eq=False)
class RecoveredStress:
    """Smooth stress field of polynomials around the corners."""

    nodes: np.ndarray  # (n_nodes, d)
    order: int
    radius: np.ndarray  # (n_nodes,) of every patch, which its monomials are scaled by
    coefficients: np.ndarray  # (n_nodes, n_terms, k)

    def at(self, block: ElementBlock, elements: np.ndarray, functions: Any, points: np.ndarray) -> np.ndarray:
        """Values (n_e, n_points, k) at points (d, n_points) of the reference element of some elements."""
        corners, straight = _corners(block)[elements], STRAIGHT[_family(block)]()
        x = np.moveaxis(np.asarray(functions.global_coordinates()), 0, -1)
        total = np.zeros((*x.shape[:2], self.coefficients.shape[2]))
        for i, corner in enumerate(_in_order_of(straight, block, corners).T):
            terms = monomials((x - self.nodes[corner][:, None]) / self.radius[corner, None, None], self.order)
            total += straight.lbasis(points, i)[0][:, None] * np.einsum("eqk,ekc->eqc", terms, self.coefficients[corner])
        return total


def recovered(blocks: Sequence[ElementBlock], nodes: np.ndarray, samples: Sequence[np.ndarray]) -> RecoveredStress:
    """Smooth stress field, recovered from samples in the elements.

    Parameters
    ----------
    samples : of every block (n_e, n_points, k), at `sample_points`
    """
    order = 1 if all(block.kind in LINEAR for block in blocks) else 2
    places, corners, members = _places(blocks)
    values = np.concatenate([each.reshape(-1, each.shape[-1]) for each in samples])
    meeting = _incidence(corners, (len(nodes), int(members.max()) + 1))
    sampled = _incidence(np.column_stack([members, np.arange(len(members))]), (meeting.shape[1], len(members)))
    found = _fit(nodes, places, meeting @ sampled, order)
    lacking, grown = found.lacking, meeting
    for _ in range(ROUNDS):
        if not lacking.any():
            break
        grown = (meeting + _rows(lacking) @ (grown @ (grown.T @ grown))).tocsr()
        still = _fit(nodes, places, grown @ sampled, order).lacking
        meeting = (_rows(~(lacking & ~still)) @ meeting + _rows(lacking & ~still) @ grown).tocsr()
        lacking = still
    found = _fit(nodes, places, meeting @ sampled, order)
    return RecoveredStress(nodes, order, found.radius, found.coefficients(values))


@dataclass(frozen=True, eq=False)
class _Fit:
    """Least-squares fit of the polynomials of all patches."""

    radius: np.ndarray  # (n_nodes,)
    used: np.ndarray  # numbers of the corners
    normal: np.ndarray  # (n_used, n_terms, n_terms)
    rows: Any  # sparse (n_nodes n_terms, n_samples)

    @property
    def lacking(self) -> np.ndarray:
        """Whether the points of a patch leave a term open, (n_nodes,)."""
        found, sizes = np.zeros(len(self.radius), bool), np.linalg.eigvalsh(self.normal)
        found[self.used] = sizes[:, 0] < UNTOLD * sizes[:, -1]
        return found

    def coefficients(self, values: np.ndarray) -> np.ndarray:
        """Coefficients (n_nodes, n_terms, k) from values (n_samples, k) at the points; zero where there is no corner."""
        right = (self.rows @ values).reshape(len(self.radius), self.normal.shape[1], -1)
        found = np.zeros_like(right)
        found[self.used] = np.linalg.pinv(self.normal, rcond=UNTOLD, hermitian=True) @ right[self.used]
        return found


def _fit(nodes: np.ndarray, places: np.ndarray, patches: Any, order: int) -> _Fit:
    """Fit of patches (n_nodes, n_samples) of samples at places (n_samples, d)."""
    patches = patches.tocoo()
    centre, sample = patches.row, patches.col
    arms = places[sample] - nodes[centre]
    np.maximum.at(radius := np.zeros(len(nodes)), centre, np.linalg.norm(arms, axis=1))
    radius[radius == 0] = 1.0
    terms = monomials(arms / radius[centre, None], order)
    n, shape = terms.shape[1], (len(nodes), terms.shape[1], terms.shape[1])
    normal = np.zeros(shape)
    for i, j in combinations_with_replacement(range(n), 2):
        normal[:, i, j] = normal[:, j, i] = np.bincount(centre, terms[:, i] * terms[:, j], len(nodes))
    row = centre[:, None] * n + np.arange(n)
    column = np.broadcast_to(sample[:, None], row.shape)
    rows = sparse.csr_array((terms.ravel(), (row.ravel(), column.ravel())), shape=(len(nodes) * n, len(places)))
    used = np.unique(centre)
    return _Fit(radius, used, normal[used], rows)


def _rows(chosen: np.ndarray) -> Any:
    """Sparse matrix that keeps some rows, and makes others zero."""
    return sparse.diags_array(chosen.astype(float))


def _incidence(pairs: np.ndarray, shape: tuple[int, int]) -> Any:
    """Sparse matrix with ones at pairs (n, 2)."""
    return sparse.csr_array((np.ones(len(pairs)), pairs.T), shape=shape)


def sample_points(block: ElementBlock) -> np.ndarray:
    """Sample points (d, n_points) of the reference element."""
    if block.kind in WEDGES:
        return wedge_points(*WEDGES[block.kind])[0]
    return get_quadrature(block.shapes.refdom, SAMPLED.get(block.kind, 1))[0]


def monomials(x: np.ndarray, order: int) -> np.ndarray:
    """All products of up to `order` coordinates of x (..., d), at [..., term]."""
    terms = [np.ones(x.shape[:-1])]
    for degree in range(1, order + 1):
        terms += [x[..., list(axes)].prod(axis=-1) for axes in combinations_with_replacement(range(x.shape[-1]), degree)]
    return np.stack(terms, axis=-1)


def _places(blocks: Sequence[ElementBlock]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places (n, d) of all samples; pairs (corner, element); and the element of every sample (n,)."""
    places, corners, members, first = [], [], [], 0
    for block in blocks:
        x = np.moveaxis(np.asarray(block.functions_at(sample_points(block)).global_coordinates()), 0, -1)
        number, own = first + np.arange(len(x)), _corners(block)
        places.append(x.reshape(-1, x.shape[-1]))
        members.append(np.repeat(number, x.shape[1]))
        corners.append(np.column_stack([own.ravel(), np.repeat(number, own.shape[1])]))
        first += len(x)
    return np.concatenate(places), np.concatenate(corners), np.concatenate(members)


def _family(block: ElementBlock) -> str:
    return block.kind.rstrip("0123456789")


def _corners(block: ElementBlock) -> np.ndarray:
    """Nodes at the corners of every element, in the order of its shape functions."""
    return block.connectivity[:, : ALL_CORNERS[block.kind]]


def _in_order_of(straight: Any, block: ElementBlock, corners: np.ndarray) -> np.ndarray:
    """Corners in the order of the straight element's functions."""
    own, theirs = block.shapes.doflocs[: corners.shape[1]], straight.doflocs
    return corners[:, [int(np.argmin(np.abs(own - place).sum(axis=1))) for place in theirs]]
