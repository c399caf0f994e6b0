"""Tension of a body of beam elements: by the axial forces of each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolkit.solvers.static.static_matrix import StaticArray
from toolkit.validity.bodies.compressed.geometric_stiffness import Stiffening
from toolkit.validity.bodies.tension.pulled_body import Grown, PulledBody


class Growth(NamedTuple):
    """Growth of the elements of one body, and the forces by which it pulls at the nodes."""

    law: Stiffening
    growth: np.ndarray  # g (n_e,)
    pull: np.ndarray  # B^T S g (n,)

    @property
    def forces(self) -> np.ndarray:
        """Forces - B^T S g of the growth on the elastic coordinates, (n_f,)."""
        found: np.ndarray = -self.law.behind.shapes.T @ self.pull
        return found

    def tension(self, moved: np.ndarray) -> np.ndarray:
        """Axial forces N_2 (n_e,) of the growth, where `forces` move the elastic coordinates by `moved` (n_f,) in the scene."""
        behind = self.law.behind
        u = behind.shapes @ moved
        if not behind.is_full:
            u = u + behind.under(-self.pull[None])[0] - behind.shapes @ self.law.yielding(self.forces)
        stretched: np.ndarray = behind.forms.law[:, 0, 0] * self.growth + behind.axial_forces(u[None])[0]
        return stretched


def growths(law: Stiffening, elastic: np.ndarray) -> np.ndarray:
    """Growth g (n_t, n_e) of the elements at elastic coordinates (n_t, n_f)."""
    u = law.behind.displacements(elastic)[:, law.behind.forms.dofs]
    found: np.ndarray = np.einsum("tep,epq,teq->te", u, law.behind.stiffening[:, 0], u, optimize=True) / 2
    return found


def grown(law: Stiffening, elastic: np.ndarray) -> Growth:
    """Growth of the elements at elastic coordinates (n_f,)."""
    forms, growth = law.behind.forms, growths(law, elastic[None])[0]
    pull = np.zeros(forms.count)
    np.add.at(pull, forms.dofs, np.einsum("ekp,ek->ep", forms.rows, forms.law[:, :, 0] * growth[:, None]))
    return Growth(law, growth, pull)


@dataclass(frozen=True, eq=False)
class PulledChain(PulledBody):
    """A body of beam elements whose geometric stiffness is that of all elements."""

    law: Stiffening

    def stiffness(self, elastic: np.ndarray) -> StaticArray:
        """Geometric stiffness G_1 of axial forces alone."""
        return self.law.of_axial(self.law.forces @ elastic)

    def grown(self, elastic: np.ndarray) -> Grown:
        """Forces and stiffness by the growth of all elements at elastic coordinates (n_f,)."""
        found = grown(self.law, elastic)

        def stiffness(moved: np.ndarray) -> StaticArray:
            return self.law.of_axial(found.tension(moved))

        return Grown(found.forces, stiffness)

    def measures(self, elastic: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of N / P by axial forces, and by the growth of lines if they were held everywhere."""
        pulled = np.maximum(elastic @ self.law.forces.T, 0.0) @ self.law.compliances
        stretch = np.square(growths(self.law, elastic)) @ self.law.behind.forms.law[:, 0, 0]
        energy = np.sum(elastic @ self.law.stiffness * elastic, axis=1)
        return pulled, np.divide(2 * stretch, energy, out=np.zeros(len(energy)), where=energy > 0)

    def distances(self, elastic: np.ndarray) -> np.ndarray:
        """Largest displacement of the nodes at coordinates (n_t, n_f), (n_t,)."""
        found: np.ndarray = self.law.behind.distances(self.law.behind.displacements(elastic)).max(axis=1)
        return found
