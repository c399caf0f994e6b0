"""What a finite element states, whatever it is: the coordinates of its nodes, and its terms of a body's matrices.

What the plane and space differ in where finite elements become invariants: component mass matrices, and what is made of them.

With Z = [xi, Psi], theory section 1, the mass of a body enters its invariants by

    plane   G = Z^T (M_00 + M_11) Z, symmetric,   H = Z^T (M_01 - M_10) Z, antisymmetric
    space   Q_ab = Z^T M_ab Z for a <= b, symmetric for a = b

The centrifugal forces of a body that spins with omega about its frame's origin are, with the symmetric parts of the M_ab,

    plane   omega^2 (M_00 + M_11) xi
    space   sum_ij omega_i omega_j F_ij,   F_ii = (sum_a M_aa - M_ii) xi,   F_ij = -M_ij xi
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from scipy import sparse
from scipy.sparse import csr_array, issparse

from preprocessing.elements.section import Patch, Terms
from toolkit.foundation.errors import InputError
from toolkit.foundation.value_types import Matrix
from toolkit.reduced_model.model import Invariants
from toolkit.reduced_model.parts import PAIRS, SpatialInvariants

Pair = tuple[int, int]
"""Axes a and b of a component mass matrix M_ab; M_ba is its transpose."""


class ElementForm(NamedTuple):
    """Product Z^T (sum of M_ab) Z among the invariants."""

    item: str  # name of the invariant
    place: int | None  # along its first axis; None: all of it
    pairs: tuple[Pair, ...]  # whose M_ab are summed
    part: Literal["symmetric", "antisymmetric", "whole"]  # antisymmetric: of the sum without its transpose


Spin = tuple[tuple[Pair, float], ...]
"""Product of angular velocities: the M_ab whose symmetric parts make its centrifugal forces, and their weights."""


@dataclass(frozen=True)
class ElementSpace:
    """Plane or space, with the forms of its invariants."""

    dimension: int
    pairs: tuple[Pair, ...]  # the component mass matrices, those with a = b first
    forms: tuple[ElementForm, ...]
    spins: tuple[Spin, ...]
    invariants: type[Invariants] | type[SpatialInvariants]

    def by_point(self, rows: Matrix, components: int) -> Matrix:
        """Rows of the stress (n_stress * components, n_f) as the invariants have them; in the plane a point has one, sparse rows stay."""
        return rows if self.dimension == 2 or issparse(rows) else rows.reshape(-1, components, rows.shape[1])


PLANE = ElementSpace(
    2,
    ((0, 0), (1, 1), (0, 1)),
    (ElementForm("inertia", None, ((0, 0), (1, 1)), "symmetric"), ElementForm("gyroscopic", None, ((0, 1),), "antisymmetric")),
    ((((0, 0), 1.0), ((1, 1), 1.0)),),
    Invariants,
)
SPACE = ElementSpace(
    3,
    PAIRS,
    tuple(
        ElementForm("second_moment", k, (pair,), "symmetric" if pair[0] == pair[1] else "whole") for k, pair in enumerate(PAIRS)
    ),
    tuple(tuple(((a, a), 1.0) for a in range(3) if a != pair[0]) if pair[0] == pair[1] else ((pair, -1.0),) for pair in PAIRS),
    SpatialInvariants,
)
SPACES = {each.dimension: each for each in (PLANE, SPACE)}


CANCELLED_SUM = 1e-13
"""Part of the sum of the absolute values, below which a sum of some hundred numbers is round-off."""


@dataclass(frozen=True, eq=False)
class Places:
    """Rows and columns of the body's matrix, element by element."""

    elements: np.ndarray  # (n_e,) their numbers
    rows: np.ndarray  # (n_e, k)
    columns: np.ndarray  # (n_e, p)
    shape: tuple[int, int]  # of the body's matrix

    @cached_property
    def entries(self) -> tuple[np.ndarray, np.ndarray]:
        """Row and column of every number of the blocks, after each other."""
        row, column = np.broadcast_arrays(self.rows[:, :, None], self.columns[:, None, :])
        return row.ravel(), column.ravel()


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks of some elements; sums and multiples of them make no sparse matrix, which costs more than their numbers."""

    places: Places
    values: np.ndarray  # (n_e, k, p)

    __array_ufunc__ = None  # a number of numpy leaves products to this class

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of the body's matrix."""
        return self.places.shape

    @cached_property
    def sparse(self) -> csr_array:
        """Body's matrix as a sparse one, by rows."""
        return sparse.coo_array((self.values.ravel(), self.places.entries), shape=self.shape).tocsr()

    def __add__(self, other: Blocks) -> Blocks:
        if self.places is not other.places:
            raise ValueError("blocks of different elements have no sum; make matrices of them first.")
        return Blocks(self.places, self.values + other.values)

    def __rmul__(self, factor: complex) -> Blocks:
        return Blocks(self.places, factor * self.values)

    def __matmul__(self, shapes: Matrix) -> Matrix:
        return self.sparse @ shapes

    def squared(self) -> Blocks:
        """Products F^T F of rows F, no two elements of which share a row."""
        at, n = self.places, self.shape[1]
        return Blocks(Places(at.elements, at.columns, at.columns, (n, n)), np.swapaxes(self.values, 1, 2) @ self.values)


BodyMatrix: TypeAlias = Blocks | csr_array
"""Matrix of a whole body: blocks of some of its elements, or sparse."""


def without_cancelled(sums: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Real sums with zeros where all but round-off of their summands cancels; `sizes` are the sums of their absolute values."""
    return np.where(np.abs(sums) > CANCELLED_SUM * sizes, sums, 0.0)


def sparse_of(matrix: BodyMatrix) -> csr_array:
    """Sparse matrix of the body, by rows."""
    return matrix.sparse if isinstance(matrix, Blocks) else matrix.tocsr()


def weighted_sum(terms: Sequence[tuple[complex, BodyMatrix]], shape: tuple[int, int]) -> csr_array:
    """Sum of weights times matrices as one sparse matrix by rows; all blocks come into it by one conversion."""
    blocks = [(weight, each) for weight, each in terms if isinstance(each, Blocks)]
    whole = [weight * each for weight, each in terms if not isinstance(each, Blocks)]
    if blocks:
        row, column = (np.concatenate([each.places.entries[k] for _, each in blocks]) for k in (0, 1))
        value = np.concatenate([weight * each.values.ravel() for weight, each in blocks])
        whole.append(sparse.coo_array((value, (row, column)), shape=shape))
    return sum(whole[1:], whole[0]).tocsr() if whole else csr_array(shape)


class Contribution(NamedTuple):
    """One term of the matrices for unit parameters, and the polynomial of the section that multiplies it.

    A mass is multiplied by the density too, unless it is constant, stiffness and stress by Young's modulus; damping follows from mass and
    stiffness.
    """

    kind: Literal["mass", "constant mass", "stiffness", "stress"]
    patch: Patch  # whose parameters they are
    terms: Terms  # of quantities of the patch
    matrix: BodyMatrix | Mapping[Pair, BodyMatrix]  # K (n, n); rows (n_stress, n); M_ab (n, n) of all pairs of the space
    rows: BodyMatrix | None = None  # F of K = F^T F, whose product F psi keeps digits that K psi loses in stiff elements


def squared(patch: Patch, terms: Terms, rows: Blocks) -> Contribution:
    """Contribution of a stiffness F^T F, by its rows F."""
    return Contribution("stiffness", patch, terms, rows.squared(), rows)


@dataclass(frozen=True)
class Coordinates:
    """Coordinates of a body's matrices: all of node 0, then of node 1, and so on, and hidden ones.

    The first coordinates of a node are its displacements along the axes. A hidden coordinate is one in the undeformed shape and zero in
    every displacement, so that the places of points off the nodes are products with one vector too.
    """

    space: ElementSpace
    n_nodes: int
    per_node: int
    hidden: int = 0

    @property
    def nodal(self) -> int:
        """Number of nodal coordinates."""
        return self.per_node * self.n_nodes

    @property
    def n(self) -> int:
        """Number of all coordinates."""
        return self.nodal + self.hidden

    @property
    def translations(self) -> np.ndarray:
        """Unit rigid translations t_a along the axes, (d, n)."""
        found = np.zeros((self.space.dimension, self.n))
        for axis, translation in enumerate(found):
            translation[axis : self.nodal : self.per_node] = 1
        return found

    def of_nodes(self, matrix: sparse.csr_array) -> csr_array:
        """The block of a square matrix that belongs to the nodal coordinates; the matrix itself where none is hidden."""
        return matrix[: self.nodal, : self.nodal] if self.hidden else matrix

    def undeformed(self, z: Matrix) -> Matrix:
        """Matrix Z (nodal, 1 + n_f), the undeformed shape first, with the rows of the hidden coordinates; sparse as Z is."""
        return _below(z, *[np.eye(1, z.shape[1], dtype=z.dtype)] * self.hidden)

    def displacement(self, d_z: Matrix) -> Matrix:
        """Displacements or rates (nodal, k) with the rows of the hidden coordinates; sparse as they are."""
        return _below(d_z, np.zeros((self.hidden, d_z.shape[1])))


def _below(*rows: Matrix) -> Matrix:
    return sparse.vstack(rows, format="csr") if sparse.issparse(rows[0]) else np.vstack(rows)


class Element(ABC):
    """All elements of one kind in a body at one design; arrays are complex where a parameter made a complex step."""

    nodes: np.ndarray
    """Undeformed positions, (n_nodes, d)."""

    @property
    def components(self) -> int:
        """Number of stress components at a point: one, or six in space."""
        return 1

    @property
    @abstractmethod
    def coordinates(self) -> Coordinates:
        """Coordinates that the matrices belong to."""

    @abstractmethod
    def contributions(self) -> Iterator[Contribution]:
        """Terms of mass, stiffness and stress, for unit parameters; complex-safe."""

    def geometric_stiffness(self, values: Mapping[str, complex], displacement: np.ndarray) -> csr_array:
        """Geometric stiffness K_g, sparse (n, n), of the stress of a displacement (n,), linear in it; complex-safe.

        Parameters
        ----------
        values : of the parameters

        Raises
        ------
        InputError
            The kind does not tell it.
        """
        raise InputError(
            f"{type(self).__name__} does not tell how its stress stiffens it, so that spin_stiffening cannot be had. Leave the key out of "
            "[basis]."
        )
