"""What the reduced model of a body tells of its stiffening by a spin of its frame, where it was asked for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolkit.reduced_model.spatial_model import PAIRS

SPIN_STIFFENING = "spin.stiffening"
"""The item of a reduced model."""


@dataclass(frozen=True)
class Spin:
    """Geometric stiffness of the stress under the centrifugal forces of unit spins, theory section 1.

    A spin omega of the frame adds omega^2 S to the stiffness in the plane, in space sum_ab omega_a omega_b S_ab.
    """

    stiffening: np.ndarray  # (1, n_f, n_f) S; in space (6, n_f, n_f), S_ab in the order of `spatial_model.PAIRS`


def stiffness_of_spin(stiffening: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Stiffness (n_f, n_f) added by a spin (3,), which is given in space in the axes of the reduced model."""
    if len(stiffening) == 1:
        found: np.ndarray = omega @ omega * stiffening[0]
        return found
    weights = [omega[a] * omega[b] * (1 if a == b else 2) for a, b in PAIRS]
    return np.tensordot(np.array(weights), stiffening, axes=1)
