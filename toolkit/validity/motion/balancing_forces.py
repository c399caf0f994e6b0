"""Forces of joints that balance all others best: of large scenes by factors that stay sparse."""

from __future__ import annotations

import numpy as np
import scipy

from toolkit.equations.equations import Terms
from toolkit.linear.linear_solver import TRUSTED_REFINEMENT
from toolkit.solvers.direct_solve import MANY
from toolkit.solvers.static.stability.static_array import largest_entry
from toolkit.system.system import System


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
