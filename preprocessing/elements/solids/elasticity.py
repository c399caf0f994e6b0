"""Matrices of isotropic elastic solids of any dimension d on the nodes of a mesh, for unit width, density and Lame's constants.

With scalar shape functions N_p, the component a of the displacement is S_a = [N_0 e_a, N_1 e_a, ...], so that all matrices are made of

    s_pq = int N_p N_q dV,    g^ab_pq = int dN_p/dx_a dN_q/dx_b dV

    M_ab = rho s in block (a, b)                                                                     theory section 1
    K    = lambda K_lambda + mu K_mu,   K_lambda = g^ab in block (a, b),   K_mu = g^ba + delta_ab sum_c g^cc in block (a, b)

Where the nodes move by V = N_k V_k per unit of a variable, the maps of the elements change by their gradients, and with them

    d(dN_p/dx_a) = -dV_c/dx_a dN_p/dx_c,    d(dV) = div V dV
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import skfem
from scipy import sparse

from preprocessing.elements.solids.elements import ElementBlock


@dataclass(frozen=True, eq=False)
class SolidMatrices:
    """The matrices for unit parameters."""

    scalar_mass: Any  # s, sparse (n_nodes, n_nodes)
    first: Any  # K_lambda, sparse (n, n)
    shear: Any  # K_mu, sparse (n, n)


def solid_matrices(
    blocks: Sequence[ElementBlock], n_nodes: int, dimension: int, motion: np.ndarray | None = None
) -> SolidMatrices:
    """Assemble the matrices over all elements; with a motion of the nodes (n_nodes, d), their derivatives along it."""
    axes = range(dimension)
    mass = sparse.csr_array((n_nodes, n_nodes))
    gradients = {(a, b): sparse.csr_array((n_nodes, n_nodes)) for a in axes for b in axes if a <= b}
    for block in blocks:
        for functions in block.functions_in_parts():
            number = block.numbering(functions, n_nodes)
            slope = None if motion is None else motion_gradient(functions, number @ motion)
            mass = mass + _assembled(_product(slope), functions, number)
            for (a, b), before in gradients.items():
                gradients[a, b] = before + _assembled(_gradient_product(a, b, slope), functions, number)
    gradients |= {(b, a): matrix.T for (a, b), matrix in gradients.items() if a < b}
    divergence = sum(gradients[a, a] for a in axes)
    first = sum(in_block(gradients[a, b], a, b, dimension) for a in axes for b in axes)
    shear = sum(in_block(gradients[b, a] + (a == b) * divergence, a, b, dimension) for a in axes for b in axes)
    return SolidMatrices(mass, first.tocsr(), shear.tocsr())


def motion_gradient(functions: Any, motion: np.ndarray) -> np.ndarray:
    """dV_c/dx_a of the motion (functions, d) at [c, a], (d, d, n_e, n_points)."""
    return np.stack([np.asarray(functions.interpolate(np.ascontiguousarray(each)).grad) for each in motion.T])


def in_block(scalar: Any, a: int, b: int, dimension: int) -> Any:
    """A matrix (n_nodes, n_nodes) between the components a and b of the displacement, (n, n)."""
    place = sparse.coo_array((np.ones(1), ([a], [b])), shape=(dimension, dimension))
    return sparse.kron(scalar, place, format="csr")


def _product(slope: np.ndarray | None) -> Any:
    def form(u: Any, v: Any, _: Any) -> Any:
        return u * v if slope is None else u * v * np.trace(slope)

    return form


def _gradient_product(a: int, b: int, slope: np.ndarray | None) -> Any:
    def form(u: Any, v: Any, _: Any) -> Any:
        if slope is None:
            return v.grad[a] * u.grad[b]
        turned = sum(slope[c, a] * v.grad[c] * u.grad[b] + slope[c, b] * v.grad[a] * u.grad[c] for c in range(len(slope)))
        return np.trace(slope) * v.grad[a] * u.grad[b] - turned

    return form


def _assembled(form: Any, functions: Any, number: Any) -> Any:
    return number.T @ sparse.csr_array(skfem.BilinearForm(form).assemble(functions)) @ number
