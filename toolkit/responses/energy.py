"""Kinetic and strain energy of the whole scene."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array

from toolkit.responses.instant import Instant
from toolkit.responses.response import Partials
from toolkit.system.solution import Solution


class KineticEnergy(Instant):
    """T = v^T M(q) v / 2, with M v taken from the inertial forces at the acceleration v."""

    kind = "kinetic-energy"
    quantity = "energy"

    def at(self, solution: Solution, step: int) -> Partials:
        """Value, and derivatives by q, v and the design."""
        system, pad = solution.system, np.zeros(solution.system.n - solution.system.n_q)
        q, v = np.concatenate([solution.q[step], pad]), np.concatenate([solution.v[step], pad])
        terms = system.evaluate(system.inputs(solution.times[step], np.zeros(3)), q, np.zeros_like(q), v, design=True)
        value_q = v @ system.matrix(terms.I_q) / 2
        n_q = system.n_q
        return Partials(v @ terms.inertial / 2, q=value_q[:n_q], v=terms.inertial[:n_q], design=v @ terms.I_x / 2)


class StrainEnergy(Instant):
    """U = q^T K q / 2 of all flexible bodies."""

    kind = "strain-energy"
    quantity = "energy"

    def at(self, solution: Solution, step: int) -> Partials:
        """Value, and derivatives by q and the design."""
        system, part, q = solution.system, solution.system.plan.constant, solution.q[step]
        shape = (system.n_q, system.n_q)
        force = coo_array((part.stiffness, (part.row, part.column)), shape=shape) @ q
        design = np.zeros(system.n_x)
        entry = part.design_entry
        change = part.design_stiffness * np.real(q[part.row[entry]] * q[part.column[entry]]) / 2
        np.add.at(design, part.design_variable, change)
        return Partials(q @ force / 2, q=force, design=design)
