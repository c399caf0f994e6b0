"""Invariants of a spatial body, their analytical derivatives and their exact polynomials: contractions of theory section 1.

With Z = [xi, Psi]:

    m      = t_a^T M_aa t_a            N[a, :] = t_a^T M_aa Z          t_a: unit rigid translation along axis a
    Q_ab   = Z^T M_ab Z for (a, b) in `toolkit.reduced_model.spatial_model.PAIRS`
    K      = Psi^T K_fe Psi            D       = Psi^T D_fe Psi        stress operator = B Psi
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from preprocessing.assembly.assembly import Part, Parts
from preprocessing.assembly.energies import energy, symmetric
from preprocessing.assembly.invariants import both_sides, polynomials_of, whole
from toolkit.reduced_model.dependence import Polynomial
from toolkit.reduced_model.spatial_model import PAIRS, SpatialInvariants

NAMES = tuple(f"m_{a}{b}" for a, b in PAIRS)
"""Names of the parts of the component mass matrices M_ab, in the order of `PAIRS`."""


@dataclass(frozen=True)
class SpatialMatrices:
    """Finite-element matrices on the n nodal coordinates of a spatial body; M_ba is the transpose of M_ab."""

    m: tuple[Any, ...]  # six sparse (n, n), M_ab in the order of `PAIRS`
    stiffness: Any  # sparse (n, n)
    damping: Any  # sparse (n, n)
    stress: Any  # sparse (n_stress * components, n), the components of one point after each other
    components: int  # of the stress at a point, 6 or 1

    @property
    def mass(self) -> Any:
        """M = M_00 + M_11 + M_22."""
        return self.m[0] + self.m[1] + self.m[2]


@dataclass(frozen=True)
class SpatialParts(Parts):
    """Parts named m_00, m_11, m_22, m_12, m_02, m_01, stiffness, damping and stress, whose sums are `SpatialMatrices`.

    `n_stress` counts the rows of the stress, points times components.
    """

    components: int = 6

    def matrices(self, one: Callable[[str], Any]) -> SpatialMatrices:
        """The matrices, each by its name."""
        return SpatialMatrices(
            tuple(one(name) for name in NAMES), one("stiffness"), one("damping"), one("stress"), self.components
        )


def contract(matrices: SpatialMatrices, z: np.ndarray, translations: np.ndarray) -> SpatialInvariants:
    """Invariants for Z = [xi, Psi], shape (n, 1 + n_f).

    Parameters
    ----------
    translations : (n, 3), nodal coordinates t_a of the unit rigid translations
    """
    psi, t_0 = z[:, 1:], translations[:, 0]
    return SpatialInvariants(
        mass=np.asarray(t_0 @ (matrices.m[0] @ t_0)),
        first_moment=_first_moment(matrices, translations, z),
        second_moment=np.stack([_moment(a, b, z.T @ (matrix @ z)) for (a, b), matrix in zip(PAIRS, matrices.m, strict=True)]),
        stiffness=symmetric(psi.T @ (matrices.stiffness @ psi)),
        damping=symmetric(psi.T @ (matrices.damping @ psi)),
        stress_operator=_by_point(matrices, matrices.stress @ psi),
    )


def contract_derivative(
    matrices: SpatialMatrices, d_matrices: SpatialMatrices, z: np.ndarray, translations: np.ndarray, d_z: np.ndarray | None = None
) -> SpatialInvariants:
    """Derivative of `contract` by one design variable, theory section 2.

    The product rule on the derivatives of the matrices, `d_matrices`, and of the basis, `d_z` = [dxi, dPsi] (None: zero).
    """
    by_matrices = contract(d_matrices, z, translations)
    if d_z is None:
        return by_matrices
    psi, d_psi = z[:, 1:], d_z[:, 1:]
    by_basis = {
        "mass": np.asarray(0.0),
        "first_moment": _first_moment(matrices, translations, d_z),
        "second_moment": np.stack(
            [_moment(a, b, both_sides(matrix, z, d_z)) for (a, b), matrix in zip(PAIRS, matrices.m, strict=True)]
        ),
        "stiffness": symmetric(both_sides(matrices.stiffness, psi, d_psi)),
        "damping": symmetric(both_sides(matrices.damping, psi, d_psi)),
        "stress_operator": _by_point(matrices, matrices.stress @ d_psi),
    }
    return SpatialInvariants(**{name: getattr(by_matrices, name) + value for name, value in by_basis.items()})


def polynomials(
    parts: SpatialParts, parameters: Sequence[str], z: np.ndarray, translations: np.ndarray, computed: bool = True
) -> dict[str, Polynomial]:
    """Exact dependence of every invariant on the parameters, for a constant Z (n, 1 + n_f); see `invariants.polynomials`."""
    return polynomials_of(
        parts, parameters, z, SpatialInvariants, lambda part, factor: _contractions(part, factor, translations), computed
    )


def _contractions(part: Part, z: Any, translations: np.ndarray) -> Iterator[tuple[str, Any]]:
    """What one part of one matrix adds to the invariants, for unit parameters and sparse or dense Z."""
    psi, matrix, width = z[:, 1:], part.matrix, z.shape[1]
    if part.name in ("stiffness", "damping"):
        yield part.name, energy(part, psi)
        return
    if part.name == "stress":
        yield "stress_operator", matrix @ psi
        return
    number = NAMES.index(part.name)
    a, b = PAIRS[number]
    moment = whole(_moment(a, b, z.T @ (matrix @ z)))
    place = number * width**2 + np.ravel_multi_index(moment.coords, moment.shape)
    yield "second_moment", sparse.coo_array((moment.data, (np.zeros(len(place), int), place)), shape=(1, len(NAMES) * width**2))
    if a == b:
        row = z.T @ (matrix.T @ translations[:, a])
        yield "first_moment", sparse.coo_array((row, (np.full(width, a), np.arange(width))), shape=(3, width))
    if a == b == 0:
        yield "mass", np.atleast_2d(translations[:, 0] @ (matrix @ translations[:, 0]))


def _moment(a: int, b: int, matrix: Any) -> Any:
    """Q_ab, which is symmetric for a = b."""
    return symmetric(matrix) if a == b else matrix


def _first_moment(matrices: SpatialMatrices, translations: np.ndarray, z: np.ndarray) -> np.ndarray:
    return np.stack([t @ (matrix @ z) for t, matrix in zip(translations.T, matrices.m[:3], strict=True)])


def _by_point(matrices: SpatialMatrices, rows: np.ndarray) -> np.ndarray:
    """Rows of the stress (n_stress * components, n_f) as (n_stress, components, n_f)."""
    return rows.reshape(-1, matrices.components, rows.shape[1])
