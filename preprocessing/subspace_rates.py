"""Derivatives of the space that the kept modes span, whatever the eigenvalues inside it do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from preprocessing.bordered_system import bordered_system
from preprocessing.constrained_pencil import ConstrainedPencil
from preprocessing.normal_modes import NormalModes, cluster, frequencies
from toolkit.errors import InputError


def subspace_rates(modes: NormalModes, d_pencils: Sequence[ConstrainedPencil]) -> np.ndarray:
    """Derivatives dPhi (n, m, n_x) of the kept modes by the design variables whose dK, dM and dR are given.

    For every mode j one matrix is factored, for all variables, and dropped again (eta: multipliers of the mode):

        [K - lambda_j M, R^T, M Phi] [ dphi_j]   [-(dK - lambda_j dM) phi_j - dR^T eta_j]
        [R,              0,   0    ] [ deta_j] = [-dR phi_j                             ]
        [Phi^T M,        0,   0    ] [-dS_j  ]   [-1/2 Phi^T dM phi_j                   ]

    Nelson's method (AIAA J. 14 (1976) 1201) bordered by all kept modes instead of one: equal eigenvalues among them leave the
    matrix regular. The motion of Phi inside its own span, which no response of the reduced body feels, is fixed by
    Phi^T M dPhi = -1/2 Phi^T dM Phi.

    Raises
    ------
    InputError
        The highest kept and the lowest discarded eigenvalue are equal, so that the span has no derivative.
    """
    refuse_cut_cluster(modes)
    kept = range(modes.count)
    rates = [mode_rates(modes, j, kept, d_pencils) for j in kept]
    return np.stack(rates, axis=1) if rates else np.zeros((len(modes.shapes), 0, len(d_pencils)))


def mode_rates(modes: NormalModes, mode: int, border: Sequence[int], d_pencils: Sequence[ConstrainedPencil]) -> np.ndarray:
    """dphi (n, n_x) of one mode from the system of `subspace_rates`, bordered by the modes `border`."""
    pencil, eigenvalue = modes.pencil, modes.eigenvalues[mode]
    phi, eta = modes.shapes[:, mode], modes.multipliers[:, mode]
    basis = modes.shapes[:, list(border)]
    system = bordered_system(pencil.stiffness - eigenvalue * pencil.mass, np.vstack([pencil.rows, basis.T @ pencil.mass]))
    inertia = np.column_stack([d.mass @ phi for d in d_pencils])
    above = eigenvalue * inertia - np.column_stack([d.stiffness @ phi + d.rows.T @ eta for d in d_pencils])
    below = [-np.column_stack([d.rows @ phi for d in d_pencils]), -basis.T @ inertia / 2]
    return system.solve(above, np.vstack(below))[0]


def refuse_cut_cluster(modes: NormalModes) -> None:
    """Refuse kept modes whose last one has the eigenvalue of the first one left out.

    Raises
    ------
    InputError
        It names the modes, their frequencies, and the next numbers of modes that have a derivative.
    """
    m, spectrum = modes.count, modes.spectrum
    if m in (0, len(spectrum)):
        return
    first, behind = cluster(spectrum, m - 1)
    if behind > m:
        below, above = frequencies(spectrum[m - 1 : m + 1])
        fewer = f"{first} or {behind}" if first else f"{behind}"
        raise InputError(
            f"mode {m} ({below:.6g} Hz) is kept and mode {m + 1} ({above:.6g} Hz) is left out, but their eigenvalues are equal (to "
            f"{spectrum[m] / spectrum[m - 1] - 1:.0e}), so that the basis has no derivative. Keep {fewer} modes, or take the "
            'derivative "frozen".'
        )
