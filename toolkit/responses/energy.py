"""Kinetic and strain energy of the whole scene, or of one body."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, singledispatch
from typing import NamedTuple

import numpy as np

from toolkit.components.bodies.kernels.constant_kernel import ConstantTerms
from toolkit.foundation.near_ties import spread
from toolkit.foundation.value_types import Scalar
from toolkit.linear.linear_solver import strain_rows
from toolkit.responses.over_time import OverTime
from toolkit.responses.response import Instant, Partials, Response, slope_at
from toolkit.system.equations import Inputs
from toolkit.system.solution import Solution, deforming


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


def _add_changes_of_strains(
    part: ConstantTerms, q: np.ndarray, strain: np.ndarray, force: np.ndarray, design: np.ndarray
) -> None:
    """Add the energy's derivatives by all design variables at a fixed state, given the strains there and their forces."""
    changes = part.design_strains
    if not len(changes.row):
        return
    column = part.strains.column.reshape(len(strain), -1)[changes.row]
    moved = np.sum(changes.value.reshape(column.shape) * q[column], axis=1)
    change = changes.weight * strain[changes.row] ** 2 / 2 + force[changes.row] * moved
    np.add.at(design, changes.variable, np.real(change))


INSTANTS, DEFORMED_INSTANTS = 40, 3
"""A quantity is looked at in so many instants, evenly spread over the motion; forces of what is deformed in few."""


class Largest(NamedTuple):
    """Largest magnitude of a quantity in a motion, and of its derivatives (n_x,), as far as the solution holds any."""

    magnitude: float
    slopes: np.ndarray


def magnitude_that_counts(response: Response, solution: Solution, largest: Largest) -> float:
    """Magnitude that a response's error is compared with.

    It is the largest magnitude in the motion; but at least what Newton leaves undecided of it, so that a place, a force or a power that is
    zero by symmetry is not wrong by its own round-off.
    """
    options = solution.options or solution.system.scene.solver
    return max(largest.magnitude, options.tolerance * _size_of_kind(response, solution))


def _size_of_kind(response: Response, solution: Solution) -> float:
    """The size of quantities of a response's kind in a motion: of lengths S the scene's, of angles 1 rad, and of what measures
    mass^m length^k time^t, with the largest rate R and the largest force F of a joint or of what is deformed,

        F^m S^(k - m) R^(-t - 2 m)
    """
    system, (m, k, t) = solution.system, response.physical_dimension
    if not (m or k or t):
        return float(response.unit_quantity == "angle")
    lengths, (speeds, changes, forces) = system.scene.size, _largest(solution)
    forces = max(forces, _elastic(solution)) if m else forces
    rate = max(speeds, np.sqrt(changes), 1 / solution.whole_run[-1])
    return float((forces / lengths) ** m * lengths ** (k - m) * rate ** (-t - 2 * m))


def _elastic(solution: Solution) -> float:
    """Largest elastic force in a motion: a joint that holds nothing has a force of the round-off of the rest in balance."""
    if not deforming(solution.system.scene):
        return 0.0
    if _elastic not in solution.known:
        law, weights = StrainEnergy(), solution.system.weights[: solution.system.n_q]
        found = [law.at(solution, step).q for step in spread(len(solution.times) - 1, DEFORMED_INSTANTS)]
        forces = [np.real(each) / weights for each in found if each is not None]
        solution.known[_elastic] = float(np.abs(forces).max(initial=0.0))
    largest: float = solution.known[_elastic]
    return largest


def _largest(solution: Solution) -> tuple[float, float, float]:
    """Largest rate, acceleration and joint force in a motion, in parts of the model size."""
    if _largest not in solution.known:
        n_q, weights = solution.system.n_q, solution.system.weights
        pairs = (solution.v, weights[:n_q]), (solution.a, weights[:n_q]), (solution.multipliers, 1 / weights[n_q:])
        solution.known[_largest] = tuple(float((np.abs(np.real(each)).max(axis=0) * by).max(initial=0.0)) for each, by in pairs)
    found: tuple[float, float, float] = solution.known[_largest]
    return found


@singledispatch
def largest_in(response: Response, solution: Solution, value: Scalar) -> Largest:
    """Largest magnitude of the response's quantity in the motion: a value that just passes zero has a finite relative error."""
    return Largest(float(abs(np.real(value))), np.zeros(solution.system.n_x))


@largest_in.register
def _(response: Instant, solution: Solution, value: Scalar) -> Largest:
    look, magnitude, slopes = response.instants(solution), abs(float(np.real(value))), np.zeros(solution.system.n_x)
    for step in spread(len(solution.times) - 1, INSTANTS):
        found = look(step)
        magnitude = max(magnitude, abs(float(np.real(found.value))))
        if len(slopes):
            slopes = np.maximum(slopes, np.abs(slope_at(found, solution, step)))
    return Largest(magnitude, np.nan_to_num(slopes))


@largest_in.register
def _(response: OverTime, solution: Solution, value: Scalar) -> Largest:
    largest, duration = largest_in(response.source, solution, 0.0), _duration(solution)
    return Largest(response.of_size(largest.magnitude, duration), response.of_slopes(*largest, duration))


def _duration(solution: Solution) -> float:
    return float(solution.whole_run[-1] - solution.whole_run[0])
