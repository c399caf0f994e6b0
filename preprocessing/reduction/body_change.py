"""What a parameter without a polynomial changes of a body before the choice of its basis: Poisson's ratio, or the places of its nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from preprocessing.elements.elasticity import StressedSolid
from preprocessing.mesh.solid_mesh import SolidMesh, rigid_motions
from preprocessing.reduction.assembly import Matrices
from preprocessing.reduction.discretisation import derivative_of
from preprocessing.reduction.solid_systems import BasisChange
from preprocessing.reduction.ties import Freedom, NodeTie, freedom


@dataclass(frozen=True, eq=False)
class BodyChange:
    """Derivatives of a body by one parameter; moved nodes carry a complex step."""

    matrices: Matrices  # derivatives
    mesh: SolidMesh  # nodes real, or with an imaginary part of STEP times their motion
    ties: Mapping[str, NodeTie]  # of these nodes
    normals: Mapping[str, np.ndarray]  # of pressure surfaces at these nodes, see `BoundaryFaces.normals`
    stressed: StressedSolid | None  # with a complex step in the parameter; None without elements
    mass: csr_array | None = None  # dM (n, n) that the shapes see, and polynomials tell: it is not among `matrices`

    @property
    def motion(self) -> np.ndarray:
        """Derivative of the nodal coordinates, (n,)."""
        return derivative_of(self.mesh.nodes.ravel())

    @property
    def moves(self) -> bool:
        """Whether the nodes move."""
        return np.iscomplexobj(self.mesh.nodes)

    def freedom(self, clamped: np.ndarray) -> Freedom:
        """Independent coordinates, with a complex step."""
        return freedom(self.mesh, clamped, self.ties)

    def on(self, free: Freedom, stepped: Freedom, matrices: Matrices, averaged: tuple[str, ...]) -> BasisChange:
        """Derivatives on the independent coordinates, K^ = T^T K T and so on.

        Parameters
        ----------
        free, stepped : at the nominal design, and with the complex step
        matrices : the nominal ones
        averaged : interface points whose rows are wanted, in their order
        """
        nodes = self.matrices.coordinates.of_nodes
        if not self.moves:
            change_of_stiffness = (free.map.T @ nodes(self.matrices.stiffness) @ free.map).tocsr()
            return BasisChange(change_of_stiffness, *self._mass_on(free))
        d_map = derivative_of(stepped.map)

        def change(matrix: csr_array, rate: csr_array) -> csr_array:
            turned = d_map.T @ (nodes(matrix) @ free.map)
            return (free.map.T @ (nodes(rate) @ free.map) + turned + turned.T).tocsr()

        rows = [derivative_of(self.ties[name].rows @ stepped.map).toarray() for name in averaged]
        return BasisChange(
            change(matrices.stiffness, self.matrices.stiffness),
            change(matrices.mass, self.matrices.mass),
            np.vstack([np.zeros((0, free.map.shape[1])), *rows]),
            derivative_of(stepped.coordinates_of(rigid_motions(self.mesh.nodes), self.ties)),
        )

    def _mass_on(self, free: Freedom) -> tuple[csr_array | None, None, np.ndarray | None]:
        """Derivatives of a body whose nodes keep their places: of the mass, of no rows, and none of the rigid motions."""
        if self.mass is None:
            return None, None, None
        return (free.map.T @ self.mass @ free.map).tocsr(), None, np.zeros((free.map.shape[1], self.mesh.motions))
