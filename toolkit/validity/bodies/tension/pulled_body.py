"""What a check of tension needs to know of a body, whatever it is made of."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from toolkit.solvers.static.static_matrix import StaticArray


class Grown(NamedTuple):
    """What a deflection pulls with at the elastic coordinates, and what it stiffens the body by."""

    forces: np.ndarray  # (n_f,)
    stiffness: Callable[[np.ndarray], StaticArray]  # G_2 (n_f, n_f), where the forces move the coordinates by (n_f,) in the scene


class PulledBody(ABC):
    """A body whose tension is known."""

    @abstractmethod
    def stiffness(self, elastic: np.ndarray) -> StaticArray:
        """G_1 (n_f, n_f) of the forces along it that it knows at elastic coordinates (n_f,)."""

    @abstractmethod
    def grown(self, elastic: np.ndarray) -> Grown:
        """What its lines do at elastic coordinates (n_f,), which grow where they turn."""

    @abstractmethod
    def measures(self, elastic: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How much forces along it, and its growth, may stiffen it at most, at coordinates (n_t, n_f): two of shape (n_t,)."""

    @abstractmethod
    def distances(self, elastic: np.ndarray) -> np.ndarray:
        """The largest displacement in its frame at coordinates (n_t, n_f), (n_t,)."""
