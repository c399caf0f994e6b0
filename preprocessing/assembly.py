"""Sparse matrices of the whole skin on its nodal coordinates, at one design and their derivatives by the section's parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from scipy import sparse

from preprocessing import beam, stress
from preprocessing.mesh import CurveMesh
from preprocessing.section import (
    BENDING,
    CURVATURE_STRESS,
    MASS,
    STRAIN_STRESS,
    STRETCHING,
    Exponents,
    Section,
    monomial,
    monomial_derivative,
)


@dataclass(frozen=True)
class Matrices:
    """Finite-element matrices on the n nodal coordinates, theory section 1; M_21 is the transpose of M_12."""

    m_11: Any  # sparse (n, n)
    m_12: Any  # sparse (n, n)
    m_22: Any  # sparse (n, n)
    stiffness: Any  # sparse (n, n)
    damping: Any  # sparse (n, n)
    stress: Any  # sparse (n_stress, n)


@dataclass(frozen=True)
class Rayleigh:
    """Factors of the damping matrix D = mass M + stiffness K, in 1/s and s."""

    mass: float = 0.0
    stiffness: float = 0.0


Parts = Mapping[Exponents, Matrices]
"""The matrices as a polynomial of the section: the sum of every part times its monomial."""


def assemble(mesh: CurveMesh, rayleigh: Rayleigh) -> dict[Exponents, Matrices]:
    """Parts of the matrices; what depends on geometry only stands here, what depends on the section in the monomials.

    With the thickness t and the width b of the section:

        M_ab = rho b t (...),   K = E b t K_1 + E b t^3 K_3,   D = a M + b K,   stress = E (...) + E t (...)
    """
    ends = mesh.ends
    mass = beam.component_mass(ends)
    m_11, m_12, m_22 = (_square(mesh, mass[:, a, b]) for a, b in ((0, 0), (0, 1), (1, 1)))
    stretching = _square(mesh, beam.stretching_stiffness(ends))
    bending = _square(mesh, beam.bending_stiffness(ends) / 12)  # I = b t^3 / 12
    return {
        MASS: _part(mesh, m_11=m_11, m_12=m_12, m_22=m_22, damping=rayleigh.mass * (m_11 + m_22)),
        STRETCHING: _part(mesh, stiffness=stretching, damping=rayleigh.stiffness * stretching),
        BENDING: _part(mesh, stiffness=bending, damping=rayleigh.stiffness * bending),
        STRAIN_STRESS: _part(mesh, stress=_rows(mesh, stress.strain_rows(ends))),
        CURVATURE_STRESS: _part(mesh, stress=_rows(mesh, stress.curvature_rows(ends))),
    }


def matrices_at(parts: Parts, section: Section) -> Matrices:
    """Matrices at one design."""
    return _weighted_sum(parts, {exponents: monomial(section, exponents) for exponents in parts})


def derivative(parts: Parts, section: Section, parameter: str) -> Matrices:
    """Analytical derivative of the matrices by one parameter of the section."""
    return _weighted_sum(parts, {exponents: monomial_derivative(section, exponents, parameter) for exponents in parts})


def _weighted_sum(parts: Parts, weights: Mapping[Exponents, float | complex]) -> Matrices:
    names = [f.name for f in fields(Matrices)]
    return Matrices(**{name: sum(weights[e] * getattr(part, name) for e, part in parts.items()) for name in names})


def _part(mesh: CurveMesh, **matrices: Any) -> Matrices:
    n, n_stress = 3 * len(mesh.nodes), 4 * len(mesh.connectivity)
    zero = {f.name: sparse.csr_array((n_stress if f.name == "stress" else n, n)) for f in fields(Matrices)}
    return Matrices(**{**zero, **matrices})


def _square(mesh: CurveMesh, blocks: np.ndarray) -> Any:
    """Sum element blocks (n_e, 6, 6) into one sparse matrix."""
    rows, columns = np.broadcast_arrays(mesh.dofs[:, :, None], mesh.dofs[:, None, :])
    n = 3 * len(mesh.nodes)
    return sparse.coo_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(n, n)).tocsr()


def _rows(mesh: CurveMesh, blocks: np.ndarray) -> Any:
    """Stack element rows (n_e, 4, 6) into one sparse matrix."""
    n_rows = 4 * len(mesh.connectivity)
    rows, columns = np.broadcast_arrays(np.arange(n_rows).reshape(-1, 4, 1), mesh.dofs[:, None, :])
    return sparse.coo_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(n_rows, 3 * len(mesh.nodes))).tocsr()
