"""Invariants of a planar body, their analytical derivatives and their exact polynomials: contractions of theory section 1.

With Z = [xi, Psi]:

    m      = t_a^T M_aa t_a            N[a, :] = t_a^T M_aa Z          t_a: unit rigid translation along axis a
    G      = Z^T (M_11 + M_22) Z       H       = Z^T (M_12 - M_21) Z
    K      = Psi^T K_fe Psi            D       = Psi^T D_fe Psi        stress operator = B Psi
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array, issparse

from preprocessing.assembly.assembly import Matrices, Part, Parts
from preprocessing.assembly.energies import antisymmetric, energy, symmetric
from preprocessing.elements.section import Monomial
from toolkit.reduced_model.dependence import Polynomial
from toolkit.reduced_model.model import Invariants

BEAM = 3
"""Coordinates of a node of a beam, x, y and rotation; nodes of solids have x and y only."""


def translation(n: int, axis: int, per_node: int = BEAM) -> np.ndarray:
    """t_a: nodal coordinates of a unit rigid translation along axis 0 or 1, (n,)."""
    column = np.zeros(n)
    column[axis::per_node] = 1
    return column


def contract(matrices: Matrices, z: np.ndarray, per_node: int = BEAM) -> Invariants:
    """Invariants for Z = [xi, Psi], shape (n, 1 + n_f)."""
    psi = z[:, 1:]
    t_1, t_2 = translation(len(z), 0, per_node), translation(len(z), 1, per_node)
    return Invariants(
        mass=np.asarray(t_1 @ (matrices.m_11 @ t_1)),
        first_moment=np.stack([t_1 @ (matrices.m_11 @ z), t_2 @ (matrices.m_22 @ z)]),
        inertia=symmetric(z.T @ (_trace(matrices) @ z)),
        gyroscopic=antisymmetric(z.T @ (_skew(matrices) @ z)),
        stiffness=symmetric(psi.T @ (matrices.stiffness @ psi)),
        damping=symmetric(psi.T @ (matrices.damping @ psi)),
        stress_operator=matrices.stress @ psi,
    )


def contract_derivative(
    matrices: Matrices, d_matrices: Matrices, z: np.ndarray, d_z: np.ndarray | None = None, per_node: int = BEAM
) -> Invariants:
    """Derivative of `contract` by one design variable, theory section 2.

    The product rule on the derivatives of the matrices, `d_matrices`, and of the basis, `d_z` = [dxi, dPsi] (None: zero).
    """
    by_matrices = contract(d_matrices, z, per_node)
    if d_z is None:
        return by_matrices
    psi, d_psi = z[:, 1:], d_z[:, 1:]
    t_1, t_2 = translation(len(z), 0, per_node), translation(len(z), 1, per_node)
    by_basis = {
        "mass": np.asarray(0.0),
        "first_moment": np.stack([t_1 @ (matrices.m_11 @ d_z), t_2 @ (matrices.m_22 @ d_z)]),
        "inertia": symmetric(both_sides(_trace(matrices), z, d_z)),
        "gyroscopic": antisymmetric(both_sides(_skew(matrices), z, d_z)),
        "stiffness": symmetric(both_sides(matrices.stiffness, psi, d_psi)),
        "damping": symmetric(both_sides(matrices.damping, psi, d_psi)),
        "stress_operator": matrices.stress @ d_psi,
    }
    return Invariants(**{name: getattr(by_matrices, name) + value for name, value in by_basis.items()})


def polynomials(
    parts: Parts, parameters: Sequence[str], z: np.ndarray, per_node: int = BEAM, computed: bool = True
) -> dict[str, Polynomial]:
    """Exact dependence of every invariant on the parameters, for a constant Z (n, 1 + n_f).

    The contractions are linear in the matrices, so every part of the matrices gives one term of those invariants that it enters;
    invariants that are zero at every design have no polynomial. Of shapes that were `computed`, not selected, all entries are
    told, zero or not.
    """
    return polynomials_of(parts, parameters, z, Invariants, lambda part, factor: _contractions(part, factor, per_node), computed)


Contractions = Callable[[Part, Any], Iterator[tuple[str, Any]]]
"""What one part of one matrix adds to the invariants, by their names, for unit parameters and a sparse or dense Z."""


def polynomials_of(
    parts: Parts, parameters: Sequence[str], z: np.ndarray, kind: type, contractions: Contractions, computed: bool
) -> dict[str, Polynomial]:
    """The polynomials of all invariants, fields of `kind`, from the contractions of every part."""
    factor = z if computed else csr_array(z)
    terms: dict[str, list[Term]] = {f.name: [] for f in fields(kind)}
    for part in parts.parts:
        for name, contraction in contractions(part, factor):
            found = whole(contraction)
            if np.any(found.data):
                terms[name].append((part.factors, np.ravel_multi_index(found.coords, found.shape), found.data))
    return {name: _polynomial(found, list(parameters)) for name, found in terms.items() if found}


Term = tuple[Monomial, np.ndarray, np.ndarray]
"""A monomial, places in the flattened invariant, and the coefficients there."""


def _polynomial(terms: list[Term], parameters: list[str]) -> Polynomial:
    width = max(len(factors) for factors, _, _ in terms)
    factor, power = np.full((len(terms), width), -1), np.zeros((len(terms), width), np.int64)
    for k, (factors, _, _) in enumerate(terms):
        for j, (name, exponent) in enumerate(factors):
            factor[k, j], power[k, j] = parameters.index(name), exponent
    numbers = np.repeat(np.arange(len(terms)), [len(entry) for _, entry, _ in terms])
    return Polynomial(
        factor, power, numbers, np.concatenate([entry for _, entry, _ in terms]), np.concatenate([value for _, _, value in terms])
    )


def whole(matrix: Any) -> Any:
    """Entries with their places: all of a dense matrix, zero or not, and those that a sparse one has."""
    if issparse(matrix):
        return matrix.tocoo()
    places = np.indices(matrix.shape).reshape(2, -1)
    return coo_array((matrix.ravel(), (places[0], places[1])), shape=matrix.shape)


def _contractions(part: Part, z: Any, per_node: int) -> Iterator[tuple[str, Any]]:
    """What one part of one matrix adds to the invariants, for unit parameters and sparse or dense Z."""
    psi, t, matrix = z[:, 1:], [translation(z.shape[0], axis, per_node) for axis in (0, 1)], part.matrix
    if part.name in ("stiffness", "damping"):
        yield part.name, energy(part, psi)
    elif part.name == "stress":
        yield "stress_operator", matrix @ psi
    elif part.name == "m_12":
        yield "gyroscopic", antisymmetric(z.T @ ((matrix - matrix.T) @ z))
    else:
        axis = 0 if part.name == "m_11" else 1
        row, width = z.T @ (matrix.T @ t[axis]), z.shape[1]
        yield "first_moment", coo_array((row, (np.full(width, axis), np.arange(width))), shape=(2, width))
        yield "inertia", symmetric(z.T @ (matrix @ z))
        if axis == 0:
            yield "mass", np.atleast_2d(t[0] @ (matrix @ t[0]))


def _trace(matrices: Matrices) -> Any:
    return matrices.m_11 + matrices.m_22


def _skew(matrices: Matrices) -> Any:
    return matrices.m_12 - matrices.m_12.T


def both_sides(matrix: Any, z: np.ndarray, d_z: np.ndarray) -> np.ndarray:
    """dZ^T M Z + Z^T M dZ."""
    return d_z.T @ (matrix @ z) + z.T @ (matrix @ d_z)
