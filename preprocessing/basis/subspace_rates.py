"""Derivatives of the space that the kept modes span, whatever the eigenvalues inside it do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from preprocessing.basis.bordered_system import bordered_system
from preprocessing.basis.constrained_pencil import ConstrainedPencil
from preprocessing.basis.normal_modes import NormalModes, cluster, frequencies
from toolkit.foundation.errors import InputError


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
    if not modes.count or not d_pencils:
        return np.zeros((*modes.shapes.shape, len(d_pencils)))
    kept = range(modes.count)
    loads = mode_loads(modes, d_pencils)
    return np.stack([mode_rates(modes, j, kept, loads) for j in kept], axis=1)


@dataclass(frozen=True, eq=False)
class ModeLoads:
    """Products of the matrices' derivatives with every mode; the last axis is the design variable."""

    inertia: np.ndarray  # dM phi_j, (n, m, n_x)
    force: np.ndarray  # (dK - lambda_j dM) phi_j + dR^T eta_j, (n, m, n_x)
    gap: np.ndarray  # dR phi_j, (n_r, m, n_x)


def mode_loads(modes: NormalModes, d_pencils: Sequence[ConstrainedPencil]) -> ModeLoads:
    """Products of dK, dM and dR with all modes."""
    inertia = np.stack([d.mass @ modes.shapes for d in d_pencils], axis=-1)
    force = np.stack([d.stiffness @ modes.shapes + d.rows.T @ modes.multipliers for d in d_pencils], axis=-1)
    gap = np.stack([d.rows @ modes.shapes for d in d_pencils], axis=-1)
    return ModeLoads(inertia, force - modes.eigenvalues[:, None] * inertia, gap)


def mode_rates(modes: NormalModes, mode: int, border: Sequence[int], loads: ModeLoads) -> np.ndarray:
    """Derivatives dphi (n, n_x) of one mode from the system of `subspace_rates`, bordered by the modes `border`."""
    pencil, basis = modes.pencil, modes.shapes[:, list(border)]
    shifted = pencil.stiffness - modes.eigenvalues[mode] * pencil.mass
    system = bordered_system(shifted, np.vstack([pencil.rows, basis.T @ pencil.mass]))
    below = np.vstack([-loads.gap[:, mode], -basis.T @ loads.inertia[:, mode] / 2])
    return system.solve(-loads.force[:, mode], below)[0]


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
