"""What the stress of a displacement adds to the stiffness of a solid.

    K_g = int sigma_ab d phi_p / dx_a d phi_q / dx_b dV   between the nodes p and q, the same for every component of the displacement

which is the work of the stress on the quadratic part of Green's strain (Zienkiewicz and Taylor, The Finite Element Method, vol. 2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from preprocessing.elements.solids.elements import ElementBlock


@dataclass(frozen=True, eq=False)
class StressedSolid:
    """Elements of a solid, and Lame's constants for unit modulus; complex where a parameter made a complex step."""

    blocks: Sequence[ElementBlock]
    lame: tuple[Any, Any]  # lambda / E and mu / E
    motion: np.ndarray | None = (
        None  # (n_nodes, d), imaginary displacement of the nodes that is so small that its square vanishes
    )

    def stiffness(self, displacement: np.ndarray) -> Any:
        """Geometric stiffness K_g for unit modulus and width, sparse (n, n), of a displacement (n,), real or complex."""
        entries = [np.concatenate(each) for each in zip(*self._entries(displacement), strict=True)]
        d = self.blocks[0].geometry.p.shape[0]
        n = len(displacement) // d
        return sparse.kron(sparse.coo_array((entries[2], (entries[0], entries[1])), shape=(n, n)), np.eye(d), format="csr")

    def _entries(self, displacement: np.ndarray) -> Any:
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

    def _measured(self, functions: Any, members: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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
