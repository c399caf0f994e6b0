"""The tension that a deflection gives to what is held at its ends: of second order, and so unknown to a linear body.

A deflection w makes the line of an element longer by g = 1/2 int w'^2 dx. Where nothing holds the ends of the body they come nearer by
that, and no force is left. What the body itself holds (nodes that its frame is tied to) and what the joints of the scene hold keeps the
line long, and leaves the axial forces

    N_2 = S (g + B u_2)

where u_2 is the displacement that the forces - B^T S g lead to: of all elements of the body alone, whatever its basis holds, and on top
what the joints add to it, which the basis has to know.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.validity.bodies.compressed.geometric_stiffness import Stiffening


class Growth(NamedTuple):
    """Growth of the elements of one body, and what it pulls with at its nodes."""

    law: Stiffening
    growth: np.ndarray  # g (n_e,)
    pull: np.ndarray  # B^T S g (n,)

    @property
    def forces(self) -> np.ndarray:
        """- B^T S g on the elastic coordinates, (n_f,)."""
        found: np.ndarray = -self.law.behind.shapes.T @ self.pull
        return found

    def tension(self, moved: np.ndarray) -> np.ndarray:
        """N_2 (n_e,), where `forces` move the elastic coordinates by `moved` (n_f,) in the scene."""
        behind = self.law.behind
        u = behind.shapes @ moved
        if not behind.is_full:
            u = u + behind.under(-self.pull[None])[0] - behind.shapes @ self.law.yielding(self.forces)
        stretched: np.ndarray = behind.forms.law[:, 0, 0] * self.growth + behind.axial_forces(u[None])[0]
        return stretched


def growths(law: Stiffening, elastic: np.ndarray) -> np.ndarray:
    """g (n_t, n_e) at elastic coordinates (n_t, n_f)."""
    u = law.behind.displacements(elastic)[:, law.behind.forms.dofs]
    found: np.ndarray = np.einsum("tep,epq,teq->te", u, law.behind.stiffening[:, 0], u, optimize=True) / 2
    return found


def grown(law: Stiffening, elastic: np.ndarray) -> Growth:
    """At elastic coordinates (n_f,)."""
    forms, growth = law.behind.forms, growths(law, elastic[None])[0]
    pull = np.zeros(forms.count)
    np.add.at(pull, forms.dofs, np.einsum("ekp,ek->ep", forms.rows, forms.law[:, :, 0] * growth[:, None]))
    return Growth(law, growth, pull)
