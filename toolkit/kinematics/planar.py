"""Orientation in the plane: the only place of the descriptions that knows how it is parametrised."""

import numpy as np


def rotation(angle: complex) -> np.ndarray:
    """Rotation matrix A(angle) = [[cos, -sin], [sin, cos]]; real or complex angle in rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def unit_vector(vector: np.ndarray) -> np.ndarray:
    """The vector divided by its length, also for complex components (no modulus)."""
    return vector / np.sqrt(vector @ vector)
