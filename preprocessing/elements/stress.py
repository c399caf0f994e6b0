"""Stress in the outer and inner fibre at both ends of every beam element.

    sigma = E (eps + f kappa t / 2),    f = +1 outer fibre, -1 inner fibre

The skin runs from F round the nose to G, anticlockwise, so its outside lies to the right of the direction of travel, at
n = -t/2 in the axes of the beam (n = direction turned by +90 degrees). There the strain eps - n kappa is eps + kappa t / 2: a
skin that is bent more strongly round the nose (kappa > 0) is in tension outside. `eps` and `kappa` are changes from the
undeformed shape, which is free of stress.
"""

from __future__ import annotations

import numpy as np

from preprocessing.elements import beam
from toolkit.reduced_model.model import StressPoints

FIBRES = np.array([1, -1])


def stress_points(n_elements: int) -> StressPoints:
    """Places of the rows: for every element its ends 0 and 1, at each end the fibres +1 and -1."""
    element, end, fibre = np.meshgrid(np.arange(n_elements), [0, 1], FIBRES, indexing="ij")
    return StressPoints(element.ravel(), end.ravel(), fibre.ravel())


def strain_rows(ends: np.ndarray) -> np.ndarray:
    """Rows of eps at the stress points, to be multiplied by E; (n_e, 4, 6)."""
    return np.repeat(beam.strain(ends)[:, None, :], 4, axis=1)


def curvature_rows(ends: np.ndarray) -> np.ndarray:
    """Rows of f kappa / 2 at the stress points, to be multiplied by E t; (n_e, 4, 6)."""
    rows = beam.curvature(ends)[:, :, None, :] * FIBRES[:, None] / 2
    return rows.reshape(len(ends), 4, 6)
