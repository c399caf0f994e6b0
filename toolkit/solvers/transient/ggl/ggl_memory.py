"""Memory of the steps of stabilised index 2.

In other formulations it is a record of the same type, so that the step loop is compiled once.
"""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from toolkit.equations.equations import Plan, Terms, allocate_terms
from toolkit.foundation.compiled.calls import in_memory
from toolkit.foundation.compiled.rows import filled_up
from toolkit.linear.linear_solver import LinearSolver, linear_solver
from toolkit.linear.sparse_analysis import analyse
from toolkit.solvers.transient.ggl.ggl_pattern import GglPattern, ggl_pattern


class Ggl(NamedTuple):
    """Constant arrays and scratch memory of stabilised index 2, with n_all = n + n_lam unknowns [a; lam; eta].

    No step leaves anything to the next.
    """

    active: bool  # whether it is the formulation of the run; nothing else counts otherwise
    pattern: GglPattern
    metric: np.ndarray  # (n_q,) W^-2
    levels: np.ndarray  # (3,) those of positions
    S: np.ndarray  # (n_phi,)
    eta: np.ndarray  # (n_lam,)
    lever: np.ndarray  # (n,) [0; eta] as accelerations and multipliers
    jacobian: np.ndarray  # values on the pattern
    residual: np.ndarray  # (n_all,)
    correction: np.ndarray  # (n_all,)
    moved: np.ndarray  # (n_q,) S times a correction of eta
    pseudo_load: np.ndarray  # (n_all, n_x filled up)
    change: np.ndarray  # (n_all, n_x) total derivative of [a; lam; eta]
    terms: Terms  # of the joints alone
    solver: LinearSolver


def allocate_ggl(plan: Plan, weights: np.ndarray, dtype: type) -> Ggl:
    """Analysed pattern and memory of stabilised index 2."""

    def zeros(*shape: int) -> np.ndarray:
        return np.zeros(shape, dtype)

    pattern, weights = ggl_pattern(plan.indptr, plan.indices, plan.n_q), weights[: plan.n_q]
    n_all = 2 * plan.n - plan.n_q
    return Ggl(
        active=True,
        pattern=pattern,
        metric=10.0 ** -np.round(2 * np.log10(weights)),
        levels=np.array([0.0, 0.0, 1.0]),
        S=zeros(len(pattern.row)),
        eta=zeros(plan.n - plan.n_q),
        lever=zeros(plan.n),
        jacobian=zeros(len(pattern.indices)),
        residual=zeros(n_all),
        correction=zeros(n_all),
        moved=zeros(plan.n_q),
        pseudo_load=zeros(n_all, filled_up(plan.n_x)),
        change=zeros(n_all, plan.n_x),
        terms=allocate_terms(plan, dtype),
        solver=linear_solver(analyse(pattern.indptr, pattern.indices, plan.n_q), weights, plan.n_x, dtype),
    )


@cache
def idle_ggl(dtype: type) -> Any:
    """Memory of stabilised index 2 for runs in other formulations, of one coordinate and one multiplier.

    It is as compiled code takes it, where the run is compiled.
    """
    plan: Any = SimpleNamespace(n_q=1, n=2, n_x=2, indptr=np.arange(3), indices=np.arange(2))
    found = allocate_ggl(plan, np.ones(2), dtype)._replace(active=False)
    return in_memory(found) if dtype is float else found
