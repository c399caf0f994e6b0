"""What a finite element states, whatever it is: the coordinates of its nodes, and its terms of a body's matrices."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy import sparse

from preprocessing.elements.blocks import Blocks
from preprocessing.elements.section import Patch
from preprocessing.elements.section_shape import Terms
from preprocessing.elements.space import Space
from toolkit.foundation.errors import InputError


class Contribution(NamedTuple):
    """One term of the matrices for unit parameters, and the polynomial of the section that multiplies it.

    A mass is multiplied by the density too, unless it is constant, stiffness and stress by Young's modulus; damping follows from mass and
    stiffness.
    """

    kind: Literal["mass", "constant mass", "stiffness", "stress"]
    patch: Patch  # whose parameters they are
    terms: Terms  # of quantities of the patch
    matrix: Any  # (a, b) -> M_ab (n, n), for all pairs of the space; K (n, n); rows (n_stress, n): blocks, or sparse
    rows: Any = None  # F of K = F^T F; of shapes that hardly strain stiff elements F psi keeps the digits that K psi loses


def squared(patch: Patch, terms: Terms, rows: Blocks) -> Contribution:
    """Contribution of a stiffness F^T F, by its rows F."""
    return Contribution("stiffness", patch, terms, rows.squared(), rows)


@dataclass(frozen=True)
class Coordinates:
    """Coordinates of a body's matrices: all of node 0, then of node 1, and so on, and hidden ones.

    The first coordinates of a node are its displacements along the axes. A hidden coordinate is one in the undeformed shape and zero in
    every displacement, so that the places of points off the nodes are products with one vector too.
    """

    space: Space
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

    def of_nodes(self, matrix: Any) -> Any:
        """The block of a square matrix that belongs to the nodal coordinates; the matrix itself where none is hidden."""
        return matrix[: self.nodal, : self.nodal] if self.hidden else matrix

    def undeformed(self, z: Any) -> Any:
        """Matrix Z (nodal, 1 + n_f), the undeformed shape first, with the rows of the hidden coordinates; sparse as Z is."""
        return _below(z, *[np.eye(1, z.shape[1], dtype=z.dtype)] * self.hidden)

    def displacement(self, d_z: Any) -> Any:
        """Displacements or rates (nodal, k) with the rows of the hidden coordinates; sparse as they are."""
        return _below(d_z, np.zeros((self.hidden, d_z.shape[1])))


def _below(*rows: Any) -> Any:
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

    def geometric_stiffness(self, values: Mapping[str, Any], displacement: np.ndarray) -> Any:
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
