"""The box that a path has filled so far: what is large and what is small on it, whatever its units and its size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SMALLEST, PART = 1e-7, 1e-2
"""Least extent of a coordinate that counts, in parts of the model size (or rad), and in parts of that of the one that moves most."""


@dataclass(frozen=True)
class Box:
    """Box that a path has filled: lowest and highest z = [q; lam; factor] (n + 1,), and the weights of coordinates (n_q,)."""

    low: np.ndarray
    high: np.ndarray
    weights: np.ndarray

    @classmethod
    def around(cls, z: np.ndarray, weights: np.ndarray) -> Box:
        """Box that holds one point alone."""
        return cls(z, z, weights)

    def with_point(self, z: np.ndarray) -> Box:
        """Box that holds one point more."""
        return Box(np.minimum(self.low, z), np.maximum(self.high, z), self.weights)

    def measure(self, change: np.ndarray) -> float:
        """Largest part of the box that a change of z (n + 1,) makes up, of a coordinate or of the load."""
        n_q, extent = len(self.weights), self.high - self.low
        moved = float(parts(self.weights * change[:n_q], self.weights * extent[:n_q]))
        return max(moved, abs(float(change[-1])) / extent[-1] if extent[-1] > 0 else 0.0)

    def metric(self) -> np.ndarray:
        """Diagonal (n + 1,) of the metric of arc length in which the box is as long in the coordinates as in the load."""
        n_q, extent = len(self.weights), self.high - self.low
        found = np.zeros(len(self.low))
        length = np.linalg.norm(self.weights * extent[:n_q])
        found[:n_q] = (self.weights / max(length, SMALLEST)) ** 2
        found[-1] = 1 / extent[-1] ** 2
        return found


def parts(change: np.ndarray, extent: np.ndarray) -> np.ndarray:
    """Largest part of a box that changes of weighted coordinates (..., n_q) make up.

    Where the model size (or rad) is larger than the box, it is compared with that.
    """
    least = np.clip(PART * extent.max(axis=-1, initial=0, keepdims=True), SMALLEST, PART)
    found: np.ndarray = (np.abs(change) / np.clip(extent, least, 1.0)).max(axis=-1, initial=0)
    return found
