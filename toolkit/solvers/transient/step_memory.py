"""Memory of the step loop: histories of all states, what one step leaves to the next, scratch."""

from typing import Any, NamedTuple

import numpy as np

from toolkit.equations.equations import Plan, Terms, Work, allocate_terms, allocate_work
from toolkit.foundation.compiled.rows import LANES, filled_up
from toolkit.linear.linear_solver import LinearSolver, cleared, linear_solver
from toolkit.linear.sparse_analysis import LUPlan
from toolkit.solvers.transient.fitted_trend import HIGHEST
from toolkit.system.system import System


class History(NamedTuple):
    """States at all times; q and v are padded to n, acc = [a; lam], leading d: total design derivative, last axis n_x."""

    q: np.ndarray  # (n_t, n)
    v: np.ndarray
    acc: np.ndarray
    dq: np.ndarray  # (n_t, n_q, n_x)
    dv: np.ndarray
    dacc: np.ndarray  # (n_t, n, n_x)
    flat_dq: np.ndarray  # (n_t, n_q n_x) the same memory, for formulas that serve vectors and blocks alike
    flat_dv: np.ndarray
    flat_dacc: np.ndarray


class Memory(NamedTuple):
    """Memory of the step loop: what one step leaves to the next, and scratch memory."""

    aux: np.ndarray  # (n,) auxiliary acceleration w
    daux: np.ndarray  # (n, n_x)
    flat_daux: np.ndarray  # (n n_x,) the same memory
    carried: np.ndarray  # (n,) carried part of the residual
    dcarried: np.ndarray  # (n, n_x filled up)
    pseudo_load: np.ndarray
    moved: np.ndarray  # scratch memory of `add_state_change`, as the next one; zero in the rows of multipliers
    rate: np.ndarray
    span: np.ndarray  # (1,) length of the step that aux belongs to, 0 at the start
    kept: np.ndarray  # (1,) length of the step that the factors belong to, 0 if they are of no use
    trend: np.ndarray  # (HIGHEST, n) differences of [a; lam] behind the last step, see `extrapolation`
    fitted: np.ndarray  # (HIGHEST,) multiples of them that would have guessed the last steps best, see `fitted_trend`
    fit_sums: np.ndarray  # (HIGHEST, LANES) normal equations of these
    fit_rows: np.ndarray  # (n_q, LANES) scratch memory of a fit, as the next ones
    fit_columns: np.ndarray  # (HIGHEST, n_q)
    fit_root: np.ndarray  # (HIGHEST, HIGHEST)
    learnt: np.ndarray  # (10,) by `extrapolation.ORDER` and its neighbours
    guess: np.ndarray  # (n,) first guess of [a; lam]
    q_predicted: np.ndarray
    v_predicted: np.ndarray
    residual: np.ndarray
    correction: np.ndarray
    jacobian: np.ndarray  # (n_entries,)
    rest: np.ndarray  # (n_entries,) the same without the factored stiffness; empty without that or gradients
    mixed: np.ndarray  # (n_entries,) scratch memory of `add_state_change`
    terms: Terms
    whole: Terms  # with the jacobian in the place of all derivatives by the state, see `step_matrix.mix`
    work: Work
    solver: LinearSolver


STATUS, STEP, ITERATIONS, AT_FAULT, ALL_ITERATIONS = range(5)
"""Places in `LoopReport.counts`: fate of the last step, its number, its Newton iterations, the unknown at fault; those of all steps."""
LAST, LARGEST, LAST_ERROR, LATE_ERROR, LARGEST_ERROR, REST = range(6)
"""Places in `LoopReport.correction`: Newton's last correction, the largest that a step was content with; the last local error, the largest
of late, the largest of all steps; the last correction, or what it left by estimate where that is why Newton stopped."""


class LoopReport(NamedTuple):
    """Report of the loop on its steps."""

    counts: np.ndarray  # (5,) by `STATUS` and its neighbours
    correction: np.ndarray  # (6,) by `LAST` and its neighbours, relative to the model size


def taken_memory(system: System, apart: bool) -> Memory:
    """Memory of the loop, one that a run has given back or a new one.

    `apart` tells whether it may keep the factored stiffness apart.
    """
    plan, weights = system.plan, system.weights[: system.n_q]
    memory = system.scratch(Memory, lambda: allocate_memory(plan, system.lu_plan, weights.copy(), system.dtype))
    parts: list[Any] = list(memory)
    while parts:
        part = parts.pop()
        if isinstance(part, np.ndarray):
            part.fill(0)
        elif isinstance(part, tuple) and not isinstance(part, Work | LinearSolver):
            parts.extend(part)
    cleared(memory.solver, weights)
    memory.work.care[1] = apart and len(memory.rest) > 0
    return memory  # in `work` states are evaluated one after the other anyway


def allocate_memory(plan: Plan, lu_plan: LUPlan, weights: np.ndarray, dtype: type) -> Memory:
    """New memory of the step loop."""

    def zeros(*shape: int) -> np.ndarray:
        return np.zeros(shape, dtype)

    n, n_x, apart = plan.n, plan.n_x, plan.n_x > 0 and len(plan.constant.strained) > 0
    daux, terms, jacobian = zeros(n, n_x), allocate_terms(plan, dtype), zeros(len(plan.indices))
    return Memory(
        aux=zeros(n),
        daux=daux,
        flat_daux=daux.reshape(-1),
        carried=zeros(n),
        **{name: zeros(n, filled_up(n_x)) for name in ("dcarried", "pseudo_load", "moved", "rate")},
        span=np.zeros(1),
        kept=np.zeros(1),
        trend=zeros(HIGHEST, n),
        fitted=np.zeros(HIGHEST),
        fit_sums=np.zeros((HIGHEST, LANES)),
        fit_rows=np.zeros((plan.n_q, LANES)),
        fit_columns=np.zeros((HIGHEST, plan.n_q)),
        fit_root=np.zeros((HIGHEST, HIGHEST)),
        learnt=np.zeros(10),
        guess=zeros(n),
        q_predicted=zeros(n),
        v_predicted=zeros(n),
        residual=zeros(n),
        correction=zeros(n),
        jacobian=jacobian,
        rest=zeros(len(plan.indices) if apart else 0),
        mixed=zeros(len(plan.indices)),
        terms=terms,
        whole=terms._replace(**dict.fromkeys(("I_acc", "I_q", "A_q", "A_v"), jacobian)),
        work=allocate_work(plan, dtype),
        solver=linear_solver(lu_plan, weights[: plan.n_q], n_x, dtype),
    )
