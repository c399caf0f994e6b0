"""Forces of joints that balance all others best: of large scenes by factors that stay sparse."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from toolkit.equations.equations import Terms
from toolkit.linear.linear_solver import TRUSTED_REFINEMENT
from toolkit.solvers.direct_solve import MANY
from toolkit.solvers.static.stability.many_states import StaticEntries
from toolkit.solvers.static.stability.static_array import largest_entry
from toolkit.system.system import System

DEPENDENT = 1e-10
"""Part of the largest entry of a triangle's diagonal below which columns may depend on each other: then singular values have to tell."""


def balancing_forces(system: System, terms: Terms) -> np.ndarray:
    """Multipliers (n_lam,) that balance the forces of a state best, in coordinates of comparable size.

    Parameters
    ----------
    system : System
    terms : Terms
        At this state, with multipliers of zero and derivatives.
    """
    n_q, weights = system.n_q, system.weights[: system.n_q]
    wanted = -(terms.inertial + terms.applied)[:n_q] / weights
    if system.n >= MANY and not len(system.plan.dropped):
        ties = scipy.sparse.csc_array(scipy.sparse.diags_array(1 / weights) @ system.matrix(terms.I_acc)[:n_q, n_q:])
        if (found := _least_squares(ties, wanted)) is not None:
            return found
    forces: np.ndarray = np.linalg.lstsq(system.dense(terms.I_acc)[:n_q, n_q:] / weights[:, None], wanted)[0]
    return forces


def balancing_forces_of(system: System, terms: Sequence[Terms]) -> np.ndarray:
    """The same of several states of a scene that is not large, (k, n_lam), by one factorisation Q R of all their ties at once."""
    n_q, entries = system.n_q, StaticEntries.on_pattern(system, np.stack([each.I_acc for each in terms]))
    tied = np.unique(entries.rows[(entries.rows < n_q) & (entries.columns >= n_q)])  # others feel none of them
    weights = system.weights[tied]
    wanted = np.stack([-(each.inertial + each.applied)[tied] / weights for each in terms])
    ties = entries.block(tied, np.arange(n_q, system.n)) / weights[:, None]
    rows, columns = ties.shape[1:]
    if not 0 < columns <= rows:
        return np.stack([np.linalg.lstsq(each, aim)[0] for each, aim in zip(ties, wanted, strict=True)])
    Q, R = np.linalg.qr(ties)
    sizes = np.abs(np.diagonal(R, axis1=1, axis2=2))
    known = sizes.min(axis=1) > DEPENDENT * sizes.max(axis=1)
    R[~known] = np.eye(columns)
    found: np.ndarray = np.linalg.solve(R, np.einsum("kij,ki->kj", Q, wanted)[..., None])[..., 0]
    for k in np.flatnonzero(~known):
        found[k] = np.linalg.lstsq(ties[k], wanted[k])[0]
    return found


def _least_squares(ties: scipy.sparse.csc_array, wanted: np.ndarray) -> np.ndarray | None:
    """G^+ b from [r 1, G; G^T, 0], refined once; None where the columns of G depend on each other."""
    rows, columns = ties.shape
    matrix = scipy.sparse.csc_array(
        scipy.sparse.block_array([[largest_entry(ties) * scipy.sparse.eye_array(rows), ties], [ties.T, None]])
    )
    given = np.append(wanted, np.zeros(columns))
    try:
        factors = scipy.sparse.linalg.splu(matrix)
    except RuntimeError:  # exactly singular
        return None
    found = factors.solve(given)
    change = factors.solve(given - matrix @ found)
    return (found + change)[rows:] if abs(change).max() <= TRUSTED_REFINEMENT * abs(found).max() else None
