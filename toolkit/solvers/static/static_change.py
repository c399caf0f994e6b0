"""Change of an equilibrium by a small change of forces, to all digits of the strains.

Solved with the entries of the static matrix alone it would have the round-off of their products, which a skin of n elements makes n^4 times
larger than their sum. So what is left of the solution is found with the stiffness in its factors B^T D B, and mended.
"""

from __future__ import annotations

import numpy as np

from toolkit.equations.equations import Inputs
from toolkit.linear.factored_matrix import strain_rows
from toolkit.solvers.direct_solve import solve_linear
from toolkit.solvers.static.equilibrium import static_matrix
from toolkit.system.system import System

MOST = 4
"""Refinements at most: of 2000 elements the entries leave 1e-5 of a solution, and so each refinement of what was left before."""
LEFT = 1e-13
"""Change of a solution, in parts of it, after which the next one is round-off."""


def static_change(
    system: System,
    inputs: Inputs,
    q: np.ndarray,
    acc: np.ndarray,
    whole: np.ndarray,
    forces: np.ndarray,
    where: str,
    transposition: np.ndarray | None = None,
) -> np.ndarray:
    """Solution A^-1 forces with the static matrix A = [K, G; J, 0] of an equilibrium, or with its transpose.

    Parameters
    ----------
    system : System
    inputs : Inputs
        What acts.
    q, acc : (n,)
        Coordinates, and [0; lam].
    whole : (n_entries,)
        That matrix, or its transpose, on the system's pattern.
    forces : (n, columns)
    where : str
        What is solved, for messages.
    transposition : (n_entries,), optional
        Place of the transposed entry of every entry; of the transpose alone.

    Returns
    -------
    (n, columns)

    Raises
    ------
    SingularSystemError
        The equations have no unique solution.
    """
    found = solve_linear(system, whole, forces, where)
    constant = system.plan.constant
    if not len(constant.strained):
        return found
    apart = static_matrix(system, system.evaluate(inputs, q, np.zeros_like(q), acc, apart=True))
    rest = system.matrix(apart if transposition is None else apart[transposition])
    strains, weight = strain_rows(constant.strains, system.n), constant.strains.weight[:, None]
    for _ in range(MOST):
        left = forces - rest @ found - strains.T @ (weight * (strains @ found))
        change = solve_linear(system, whole, left, where)
        found = found + change
        if _largest(system, change) <= LEFT * _largest(system, found):
            break
    return found


def _largest(system: System, change: np.ndarray) -> float:
    """Largest change of any coordinate, in parts of the model size or rad."""
    sizes = system.weights[: system.n_q, None] * np.abs(np.real(change[: system.n_q]))
    return float(sizes.max(initial=0.0))
