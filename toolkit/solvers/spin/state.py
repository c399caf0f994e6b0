"""One state of a scene with its linearised equations, for directions in which coordinates, velocities and accelerations change together."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.equations.equations import Inputs, Terms
from toolkit.solvers.spin.generator import Generator
from toolkit.system.system import System


class Linearised(NamedTuple):
    """Residual R at one state and its derivatives, dense.

    They are by q and v (n, n_q), by a and multipliers (n, n), and by the design (n, n_x).
    """

    residual: np.ndarray
    by_q: np.ndarray
    by_v: np.ndarray
    by_acc: np.ndarray
    by_x: np.ndarray

    def spinning(self, motion: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Stiffness (n, n) of coordinates and multipliers, damping and mass (n, n_q), for small changes in a spinning frame.

        With S = `motion` a change y of the coordinates in that frame changes q by y, v by y' + S y, a by y'' + 2 S y' + S^2 y:

            M = R_a,   C = R_v + 2 R_a S,   K = R_q + R_v S + R_a S^2
        """
        n_q = motion.shape[0]
        mass, forces = self.by_acc[:, :n_q], self.by_acc[:, n_q:]
        stiffness = self.by_q + self.by_v @ motion + mass @ motion @ motion
        return np.column_stack([stiffness, forces]), self.by_v + 2 * mass @ motion, mass


def linearised(system: System, inputs: Inputs, q: np.ndarray, v: np.ndarray, acc: np.ndarray) -> Linearised:
    """Linearised equations at q, v (n_q,) and acc = [a; lam] (n,)."""
    n_q = system.n_q
    pad = np.zeros(system.n - n_q)
    terms = system.evaluate(inputs, np.append(q, pad), np.append(v, pad), acc, design=True)
    return of_terms(system, terms)


def of_terms(system: System, terms: Terms) -> Linearised:
    """Linearised equations from the terms of the equations, whose rows of constraints are those of positions."""
    n_q = system.n_q
    by_q, by_v, by_acc = (system.dense(each) for each in (terms.I_q + terms.A_q, terms.A_v, terms.I_acc))
    by_acc[n_q:, :n_q] = 0
    for row in system.plan.dropped:
        by_acc[row, row] = 1
    return Linearised(terms.inertial + terms.applied, by_q[:, :n_q], by_v[:, :n_q], by_acc, terms.I_x + terms.A_x)


def moved(motion: Generator, q: np.ndarray, multipliers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocities (n_q,) and [a; lam] (n,) of coordinates that turn with the scene."""
    return motion.velocity(q), np.concatenate([motion.acceleration(q), multipliers])


def balancing(system: System, transposed_phi_q: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Multipliers (n_lam,) whose joint forces come nearest to balancing forces (n_q,); zero in the place of rows left out."""
    kept = np.ones(system.n - system.n_q, bool)
    kept[[row - system.n_q for row in system.plan.dropped]] = False
    found = np.zeros(len(kept), np.result_type(transposed_phi_q, forces))
    weights = system.weights[: system.n_q]
    found[kept] = np.linalg.lstsq(transposed_phi_q[:, kept] / weights[:, None], -forces / weights)[0]
    return found
