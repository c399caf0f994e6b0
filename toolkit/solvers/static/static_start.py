"""Beginning of the static path: without load, or where only the load makes a mechanism rest, at the first load step."""

from __future__ import annotations

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError, SingularSystemError
from toolkit.foundation.near_ties import first_largest
from toolkit.solvers.closing.open_joints import search, told_gap
from toolkit.solvers.closing.openings import told
from toolkit.solvers.closing.rigid_bodies import RigidBodies
from toolkit.solvers.start.initial_conditions import POSITION_TOLERANCE
from toolkit.solvers.static.descent import descend
from toolkit.solvers.static.equilibrium import Equilibrium, inputs_at
from toolkit.system.system import System


def start_of_path(system: System, options: RunOptions) -> tuple[Equilibrium, float, int]:
    """First equilibrium, its load factor, and Newton iterations spent on it.

    Raises
    ------
    ConvergenceError
        The joints cannot be closed from the given positions.
    SingularSystemError
        Something is free to move with and without load, or joints are redundant.
    """
    q = system.undeformed()[0]
    try:
        state, count = descend(system, options, 0.0, q, np.zeros_like(q))
    except (ConvergenceError, SingularSystemError) as error:
        _refuse_open_joints(system, options, q, error)
        first = 1.0 / options.load_steps
        state, count = descend(system, options, first, q, _balancing(system, options, first, q))
        return state, first, count
    return state, 0.0, count


def _refuse_open_joints(system: System, options: RunOptions, q: np.ndarray, error: Exception) -> None:
    zero, n_q = np.zeros_like(q), system.n_q
    open_by = np.real(system.evaluate(inputs_at(system, options, 0.0), q, zero, zero).applied[n_q:])
    size = np.abs(open_by) * system.weights[n_q:]
    if size.max(initial=0) > POSITION_TOLERANCE:
        row = first_largest(size)
        bodies, inputs = RigidBodies(system), inputs_at(system, options, 0.0)
        found = search(bodies, inputs, q)
        if found is not None and not found.closes:
            raise ConvergenceError(told_gap(bodies, inputs, found)) from error
        raise ConvergenceError(
            f"the joints cannot be closed from the given positions: {system.numbering.names[n_q + row]} is open by "
            f"{told(system, n_q + row, open_by[row])} "
            f"({error}). Give positions, a length or a curve that fit together."
        ) from error


def _balancing(system: System, options: RunOptions, factor: float, q: np.ndarray) -> np.ndarray:
    """[0; lam] with the joint forces that come nearest to balancing the loads.

    Their geometric stiffness may be all that there is.
    """
    zero, n_q = np.zeros_like(q), system.n_q
    terms = system.evaluate(inputs_at(system, options, factor), q, zero, zero)
    transposed_phi_q = np.real(system.dense(terms.I_acc)[:n_q, n_q:])
    multipliers = np.linalg.lstsq(transposed_phi_q, -np.real(terms.inertial + terms.applied)[:n_q])[0]
    return np.concatenate([zero[:n_q], multipliers]).astype(system.dtype)
