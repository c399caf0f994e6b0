"""Interface points that a basis holds: what its shapes move them by is round-off, and is stored as zero on every processor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from toolkit.reduced_model.model import InterfacePoint

HELD = 1e-12
"""Part of the largest displacement of a node, or of the rotation that it is over the body's size, below which a point is held."""


def with_held_points(
    interfaces: Mapping[str, InterfacePoint], displacements: np.ndarray, size: float
) -> dict[str, InterfacePoint]:
    """Interface points with zeros where all shapes together leave a position or a rotation at rest.

    Parameters
    ----------
    interfaces : by their names
    displacements : of nodes by the shapes, of any shape
    size : of the body, a length
    """
    largest = float(np.abs(displacements).max(initial=0))
    return {
        name: replace(point, position=_held(point.position, size, largest), rotation=_held(point.rotation, size, largest / size))
        for name, point in interfaces.items()
    }


def _held(coefficients: np.ndarray, size: float, largest: float) -> np.ndarray:
    """Coefficients of the powers of the arc length, which is at most the size."""
    found, powers = coefficients.copy(), np.arange(len(coefficients)).reshape(-1, *(1,) * (coefficients.ndim - 1))
    if np.abs(coefficients[..., 1:] * size**powers).max(initial=0) <= HELD * largest:
        found[..., 1:] = 0
    return found
