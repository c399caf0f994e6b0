"""The finite elements behind a body, whatever the dimension of space: nodal displacements of its elastic coordinates, and their errors."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from toolkit.validity.bodies.chains.second_order import Forms, displacements_under, second_order_displacement


@dataclass(frozen=True, eq=False)
class Chain(ABC):
    """A chain of elements with two nodes each, and how the elastic coordinates move them."""

    shapes: np.ndarray  # (n, n_f)
    held: np.ndarray  # (m, n) rows of displacements that the body's frame does not feel

    per_node: ClassVar[int]
    """Coordinates of a node: displacements, then rotations."""

    @property
    @abstractmethod
    def nodes(self) -> np.ndarray:
        """Undeformed positions of the nodes, (n_nodes, d)."""

    @abstractmethod
    def make_forms(self) -> Forms:
        """Deformations of the elements per displacement, to be kept as `forms`."""

    @abstractmethod
    def make_stiffening(self) -> np.ndarray:
        """Forms (n_e, k', p, p) whose sum, times the first k' forces of each element, is its geometric stiffness."""

    @cached_property
    def forms(self) -> Forms:
        """Deformations of the elements per displacement, and their law of forces."""
        return self.make_forms()

    @cached_property
    def stiffening(self) -> np.ndarray:
        """Forms of the geometric stiffness."""
        return self.make_stiffening()

    @property
    def is_full(self) -> bool:
        """Whether the basis holds all shapes that there are: all coordinates of nodes but those of the frame."""
        return self.shapes.shape[1] + len(self.held) >= self.shapes.shape[0]

    def displacements(self, elastic: np.ndarray) -> np.ndarray:
        """Nodal displacements (n_t, n) of elastic coordinates (n_t, n_f)."""
        return elastic @ self.shapes.T

    def second_order(self, u: np.ndarray) -> np.ndarray:
        """Displacements of second order that the linear displacements (n_t, n) lack."""
        return second_order_displacement(self.forms, self.held, u)

    def under(self, loads: np.ndarray) -> np.ndarray:
        """Linear displacements (n_t, n) of all elements under loads (n_t, n), whatever the basis holds."""
        return displacements_under(self.forms, self.held, loads)

    def axial_forces(self, u: np.ndarray) -> np.ndarray:
        """Axial forces of the elements (n_t, n_e), positive in tension, under displacements (n_t, n)."""
        return self.forms.forces(u)[:, :, 0]

    def by_node(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Displacements (n_t, n_nodes, d) and rotations (n_t, n_nodes, ..) of nodal displacements (n_t, n)."""
        each = u.reshape(len(u), -1, self.per_node)
        d = self.nodes.shape[1]
        return each[:, :, :d], each[:, :, d:]

    def distances(self, u: np.ndarray) -> np.ndarray:
        """Magnitudes (n_t, n_nodes) of nodal displacements (n_t, n)."""
        found: np.ndarray = np.linalg.norm(self.by_node(u)[0], axis=2)
        return found

    def rotations(self, u: np.ndarray) -> np.ndarray:
        """Angles (n_t, n_nodes) that nodal displacements (n_t, n) turn the nodes by."""
        found: np.ndarray = np.linalg.norm(self.by_node(u)[1], axis=2)
        return found
