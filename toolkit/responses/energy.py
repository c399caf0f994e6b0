"""Kinetic and strain energy of the whole scene, or of one body."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from toolkit.bodies.kernels.constant_kernel import Constant
from toolkit.equations.equations import Inputs
from toolkit.linear.factored_matrix import strain_rows
from toolkit.responses.instant import Instant
from toolkit.responses.response import Partials
from toolkit.system.solution import Solution


class Energy(Instant):
    """Base of energies.

    Attributes
    ----------
    body
        Name of one body; by default all of the scene count.
    """

    quantity = "energy"

    body: str | None = None

    def counted(self, solution: Solution) -> np.ndarray:
        """Which coordinates belong to the bodies that count, (n_q,)."""
        found = np.zeros(solution.system.n_q, bool)
        found[slice(None) if self.body is None else solution.coordinates(self.body)] = True
        return found


class KineticEnergy(Energy):
    """Kinetic energy T = v^T M(q) v / 2, with M v taken from the inertial forces at the acceleration v."""

    kind = "kinetic-energy"

    def at(self, solution: Solution, step: int) -> Partials:
        """Kinetic energy at a step, and its derivatives by q, v and the design."""
        return self.instants(solution)(step)

    def instants(self, solution: Solution) -> Callable[[int], Partials]:
        """Function that gives the kinetic energy and its derivatives at a step."""
        inputs = solution.system.inputs(solution.times[0], np.zeros(3))  # no curve matters to inertia
        return partial(self._at, solution, self.counted(solution), inputs)

    def _at(self, solution: Solution, counts: np.ndarray, inputs: Inputs, step: int) -> Partials:
        system, pad = solution.system, np.zeros(solution.system.n - solution.system.n_q)
        q, v = np.concatenate([solution.q[step], pad]), np.concatenate([np.where(counts, solution.v[step], 0), pad])
        terms = system.evaluate(inputs, q, np.zeros_like(q), v, design=True)
        n_q, value_q = system.n_q, np.zeros(system.n, np.result_type(v, terms.I_q))
        np.add.at(value_q, system.plan.indices, np.repeat(v, np.diff(system.plan.indptr)) * terms.I_q / 2)
        by_v = np.where(counts, terms.inertial[:n_q], 0)
        return Partials(v @ terms.inertial / 2, q=value_q[:n_q], v=by_v, design=v @ terms.I_x / 2)


class StrainEnergy(Energy):
    """Strain energy U = q^T K q / 2 of all flexible bodies, or of one."""

    kind = "strain-energy"

    def at(self, solution: Solution, step: int) -> Partials:
        """Strain energy at a step, and its derivatives by q and the design."""
        system, part = solution.system, solution.system.plan.constant
        q = np.where(self.counted(solution), solution.q[step], 0)
        by_entries, strains, changes = system.matrix(part.loose)[: system.n_q, : system.n_q] @ q, part.strains, part.design_loose
        rows = strain_rows(strains, system.n_q)
        strain = rows @ q
        force = strains.weight * strain
        design = np.zeros(system.n_x)
        counts = np.diff(changes.start)
        change = changes.value * np.real(q[np.repeat(changes.row, counts)] * q[changes.column]) / 2
        np.add.at(design, np.repeat(changes.variable, counts), change)
        _add_changes_of_strains(part, q, strain, force, design)
        return Partials((q @ by_entries + strain @ force) / 2, q=by_entries + rows.T @ force, design=design)


def _add_changes_of_strains(part: Constant, q: np.ndarray, strain: np.ndarray, force: np.ndarray, design: np.ndarray) -> None:
    """Add the energy's derivatives by all design variables at a fixed state, given the strains there and their forces."""
    changes = part.design_strains
    if not len(changes.row):
        return
    column = part.strains.column.reshape(len(strain), -1)[changes.row]
    moved = np.sum(changes.value.reshape(column.shape) * q[column], axis=1)
    change = changes.weight * strain[changes.row] ** 2 / 2 + force[changes.row] * moved
    np.add.at(design, changes.variable, np.real(change))
