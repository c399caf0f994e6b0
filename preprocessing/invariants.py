"""Invariants of a planar body, their analytical derivatives and their exact polynomials: contractions of theory section 1.

With Z = [xi, Psi]:

    m      = t_a^T M_aa t_a            N[a, :] = t_a^T M_aa Z          t_a: unit rigid translation along axis a
    G      = Z^T (M_11 + M_22) Z       H       = Z^T (M_12 - M_21) Z
    K      = Psi^T K_fe Psi            D       = Psi^T D_fe Psi        stress operator = B Psi
"""

from __future__ import annotations

from dataclasses import asdict, fields
from typing import Any

import numpy as np

from preprocessing.assembly import Matrices, Parts
from preprocessing.section import Exponents, Section, monomial
from toolkit.reduced_model import Invariants, Polynomial


def translation(n: int, axis: int) -> np.ndarray:
    """t_a: nodal coordinates of a unit rigid translation along axis 0 or 1, (n,)."""
    column = np.zeros(n)
    column[axis::3] = 1
    return column


def contract(matrices: Matrices, z: np.ndarray) -> Invariants:
    """Invariants for Z = [xi, Psi], shape (n, 1 + n_f)."""
    psi = z[:, 1:]
    t_1, t_2 = translation(len(z), 0), translation(len(z), 1)
    return Invariants(
        mass=np.asarray(t_1 @ (matrices.m_11 @ t_1)),
        first_moment=np.stack([t_1 @ (matrices.m_11 @ z), t_2 @ (matrices.m_22 @ z)]),
        inertia=z.T @ (_trace(matrices) @ z),
        gyroscopic=z.T @ (_skew(matrices) @ z),
        stiffness=psi.T @ (matrices.stiffness @ psi),
        damping=psi.T @ (matrices.damping @ psi),
        stress_operator=matrices.stress @ psi,
    )


def contract_derivative(matrices: Matrices, d_matrices: Matrices, z: np.ndarray, d_z: np.ndarray | None = None) -> Invariants:
    """Derivative of `contract` by one design variable, theory section 2.

    The product rule on the derivatives of the matrices, `d_matrices`, and of the basis, `d_z` = [dxi, dPsi] (None: zero).
    """
    by_matrices = contract(d_matrices, z)
    if d_z is None:
        return by_matrices
    psi, d_psi = z[:, 1:], d_z[:, 1:]
    t_1, t_2 = translation(len(z), 0), translation(len(z), 1)
    by_basis = {
        "mass": np.asarray(0.0),
        "first_moment": np.stack([t_1 @ (matrices.m_11 @ d_z), t_2 @ (matrices.m_22 @ d_z)]),
        "inertia": _both_sides(_trace(matrices), z, d_z),
        "gyroscopic": _both_sides(_skew(matrices), z, d_z),
        "stiffness": _both_sides(matrices.stiffness, psi, d_psi),
        "damping": _both_sides(matrices.damping, psi, d_psi),
        "stress_operator": matrices.stress @ d_psi,
    }
    return Invariants(**{name: getattr(by_matrices, name) + value for name, value in by_basis.items()})


def nonzero(invariants: Invariants) -> dict[str, np.ndarray]:
    """The invariants that are not zero, by name."""
    return {name: value for name, value in asdict(invariants).items() if np.any(value)}


def polynomials(parts: Parts, section: Section, z: np.ndarray) -> dict[str, Polynomial]:
    """Exact dependence of every invariant on the section's parameters, relative to `section`, for Z (n, 1 + n_f).

    The contractions are linear in the matrices, so every part of the matrices gives one term; invariants that are zero at every
    design have no polynomial.
    """
    terms: dict[str, list[tuple[Exponents, np.ndarray]]] = {f.name: [] for f in fields(Invariants)}
    for exponents, part in parts.items():
        for name, value in nonzero(contract(part, z)).items():
            terms[name].append((exponents, monomial(section, exponents) * value))
    return {
        name: Polynomial(np.array([exponents for exponents, _ in found]), np.stack([value for _, value in found]))
        for name, found in terms.items()
        if found
    }


def _trace(matrices: Matrices) -> Any:
    return matrices.m_11 + matrices.m_22


def _skew(matrices: Matrices) -> Any:
    return matrices.m_12 - matrices.m_12.T


def _both_sides(matrix: Any, z: np.ndarray, d_z: np.ndarray) -> np.ndarray:
    """dZ^T M Z + Z^T M dZ."""
    return d_z.T @ (matrix @ z) + z.T @ (matrix @ d_z)
