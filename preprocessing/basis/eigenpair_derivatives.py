"""Derivatives of single eigenvalues and modes, with repeated eigenvalues as what they are: directions that split."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from preprocessing.basis.constrained_pencil import ConstrainedPencil
from preprocessing.basis.normal_modes import NormalModes, cluster, frequencies
from preprocessing.basis.subspace_rates import mode_loads, mode_rates, refuse_cut_cluster
from toolkit.foundation.errors import InputError


def eigenvalue_rates(modes: NormalModes, d_pencil: ConstrainedPencil) -> np.ndarray:
    """Derivatives of the eigenvalues by one design variable, (m,).

    A single eigenvalue has dlambda = phi^T (dK - lambda dM) phi + 2 eta^T dR phi. A repeated one splits when the design changes: its
    branches have the eigenvalues of the same expression with all modes of the cluster, in increasing order.

    Raises
    ------
    InputError
        The highest kept and the lowest discarded eigenvalue are equal.
    """
    return _split(modes, d_pencil)[0]


def adapted_modes(modes: NormalModes, d_pencil: ConstrainedPencil) -> NormalModes:
    """Modes turned inside every repeated eigenvalue so that each continues smoothly when the design variable changes.

    They stand in the order of `eigenvalue_rates`; branches of equal derivative stay undetermined.

    Raises
    ------
    InputError
        The highest kept and the lowest discarded eigenvalue are equal.
    """
    turn = _split(modes, d_pencil)[1]
    return replace(modes, shapes=modes.shapes @ turn, multipliers=modes.multipliers @ turn)


def eigenvector_rates(modes: NormalModes, d_pencil: ConstrainedPencil) -> np.ndarray:
    """Derivatives (n, m) of mass-normalised modes with single eigenvalues by one design variable, Nelson's method.

    Raises
    ------
    InputError
        An eigenvalue is repeated: the derivative of its vectors depends on second derivatives of the matrices.
    """
    for first, behind in _clusters(modes):
        if behind - first > 1:
            numbers = ", ".join(str(mode + 1) for mode in range(first, behind))
            raise InputError(
                f"the modes {numbers} have one eigenvalue ({frequencies(modes.spectrum[first]):.6g} Hz), and single vectors of a "
                "repeated eigenvalue have no derivative from first derivatives of the matrices. Use eigenvalue_rates, "
                "adapted_modes, or the derivative of their span, subspace_rates."
            )
    loads = mode_loads(modes, [d_pencil])
    rates = [mode_rates(modes, j, [j], loads)[:, 0] for j in range(modes.count)]
    return np.column_stack(rates) if rates else np.zeros_like(modes.shapes)


def _clusters(modes: NormalModes) -> list[tuple[int, int]]:
    """Numbers (first, first behind) of every cluster that holds a kept mode."""
    return sorted({cluster(modes.spectrum, mode) for mode in range(modes.count)})


def _split(modes: NormalModes, d_pencil: ConstrainedPencil) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of the eigenvalues (m,) and the turn (m, m) of the modes that belongs to them."""
    refuse_cut_cluster(modes)
    rates, turn = np.zeros(modes.count), np.zeros((modes.count, modes.count))
    for first, behind in _clusters(modes):
        members = slice(first, behind)
        rates[members], turn[members, members] = np.linalg.eigh(_coupling(modes, members, d_pencil))
    return rates, turn


def _coupling(modes: NormalModes, members: slice, d_pencil: ConstrainedPencil) -> np.ndarray:
    """Coupling Phi^T (dK - lambda dM) Phi + H^T dR Phi + Phi^T dR^T H of one cluster with multipliers H."""
    phi, eta = modes.shapes[:, members], modes.multipliers[:, members]
    eigenvalue = modes.eigenvalues[members].mean()
    work = eta.T @ (d_pencil.rows @ phi)
    return phi.T @ (d_pencil.stiffness @ phi) - eigenvalue * (phi.T @ (d_pencil.mass @ phi)) + work + work.T
