"""What tension does to a body of beam elements: by the axial forces of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolkit.solvers.static.stability.static_array import StaticArray
from toolkit.validity.bodies.compressed.geometric_stiffness import Stiffening
from toolkit.validity.bodies.tension.grown_elements import grown, growths
from toolkit.validity.bodies.tension.pulled_body import Grown, PulledBody


@dataclass(frozen=True, eq=False)
class PulledChain(PulledBody):
    """Of the geometric stiffness of all elements."""

    law: Stiffening

    def stiffness(self, elastic: np.ndarray) -> StaticArray:
        """G_1 of axial forces alone."""
        return self.law.of_axial(self.law.forces @ elastic)

    def grown(self, elastic: np.ndarray) -> Grown:
        """By the growth of all elements."""
        found = grown(self.law, elastic)

        def stiffness(moved: np.ndarray) -> StaticArray:
            return self.law.of_axial(found.tension(moved))

        return Grown(found.forces, stiffness)

    def measures(self, elastic: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of N / P by axial forces, and by the growth of lines were they held everywhere."""
        pulled = np.maximum(elastic @ self.law.forces.T, 0.0) @ self.law.compliances
        stretch = np.square(growths(self.law, elastic)) @ self.law.behind.forms.law[:, 0, 0]
        energy = np.sum(elastic @ self.law.stiffness * elastic, axis=1)
        return pulled, np.divide(2 * stretch, energy, out=np.zeros(len(energy)), where=energy > 0)

    def distances(self, elastic: np.ndarray) -> np.ndarray:
        """Of the nodes."""
        found: np.ndarray = self.law.behind.distances(self.law.behind.displacements(elastic)).max(axis=1)
        return found
