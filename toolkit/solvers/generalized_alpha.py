"""The compiled step loop: generalized-alpha with exact Newton, and the sensitivities carried along.

Per step: predict, iterate to convergence, then (with design variables) solve with the Jacobian of the converged state for all design
derivatives in one block (staggered direct differentiation, paper eqs. 40-46). Nothing here allocates.
"""

from typing import NamedTuple

import numpy as np

from toolkit.equations import Inputs, Plan, Terms, Work, allocate_terms, allocate_work, evaluate, evaluate_design
from toolkit.kernel import copy, kernel
from toolkit.solvers.linear_solver import LinearSolver, factorize, linear_solver, solve_checked, solve_refined_block
from toolkit.sparse_lu import LUPlan

CONVERGED, NOT_CONVERGED, SINGULAR, NOT_FINITE = 0, 1, 2, 3

REUSED, SHARP = 1e-13, 1e-7
"""Last Newton correction up to which the last Jacobian is that of the converged state (the difference is round-off), and up to which at
least its factors still serve: one refinement with the converged Jacobian squares their relative error."""
STAGNATED = 1e-7
"""Correction below which Newton is content when round-off keeps it from shrinking further."""


class History(NamedTuple):
    """Everything at every time; q and v are padded to n, acc = [a; lam], leading d: total design derivative, last axis n_x."""

    q: np.ndarray  # (n_t, n)
    v: np.ndarray
    acc: np.ndarray
    dq: np.ndarray  # (n_t, n, n_x)
    dv: np.ndarray
    dacc: np.ndarray
    flat_dq: np.ndarray  # (n_t, n n_x) the same memory, for formulas that serve vectors and blocks alike
    flat_dv: np.ndarray
    flat_dacc: np.ndarray


class Memory(NamedTuple):
    """What one step leaves to the next, and scratch memory."""

    aux: np.ndarray  # (n,) auxiliary acceleration w
    daux: np.ndarray  # (n, n_x)
    flat_daux: np.ndarray  # (n n_x,) the same memory
    carried: np.ndarray  # (n,) carried part of the residual
    dcarried: np.ndarray  # (n, n_x)
    pseudo_load: np.ndarray  # (n, n_x)
    q_predicted: np.ndarray
    v_predicted: np.ndarray
    residual: np.ndarray
    correction: np.ndarray
    jacobian: np.ndarray  # (n_entries,)
    terms: Terms
    work: Work
    solver: LinearSolver


class Outcome(NamedTuple):
    """What the loop reports: `status`, step, Newton iterations of that step, unknown at fault; in all: iterations."""

    counts: np.ndarray  # (5,)
    correction: np.ndarray  # (1,) last Newton correction, relative to the scene's size


def allocate_memory(plan: Plan, lu_plan: LUPlan, weights: np.ndarray, dtype: type) -> Memory:
    """Memory of the loop."""

    def zeros(*shape: int) -> np.ndarray:
        return np.zeros(shape, dtype)

    n, n_x = plan.n, plan.n_x
    daux = zeros(n, n_x)
    return Memory(
        aux=zeros(n),
        daux=daux,
        flat_daux=daux.reshape(-1),
        carried=zeros(n),
        dcarried=zeros(n, n_x),
        pseudo_load=zeros(n, n_x),
        q_predicted=zeros(n),
        v_predicted=zeros(n),
        residual=zeros(n),
        correction=zeros(n),
        jacobian=zeros(len(plan.indices)),
        terms=allocate_terms(plan, dtype),
        work=allocate_work(plan, dtype),
        solver=linear_solver(lu_plan, weights[: plan.n_q], n_x, dtype),
    )


@kernel
def predict(scheme, q, v, acc, aux, count, q_new, v_new):
    """Coordinates and velocities at n + 1 for a_+ = 0; also of their sensitivities, flattened."""
    h, beta, gamma = scheme.h, scheme.beta, scheme.gamma
    for i in range(count):
        w_new = scheme.old * acc[i] - scheme.carry * aux[i]
        q_new[i] = q[i] + h * v[i] + h * h * ((0.5 - beta) * aux[i] + beta * w_new)
        v_new[i] = v[i] + h * ((1 - gamma) * aux[i] + gamma * w_new)


@kernel
def advance_auxiliary(scheme, acc, acc_new, count, aux):
    """w_+ in place of w_n; also of its sensitivities, flattened."""
    for i in range(count):
        aux[i] = scheme.new * acc_new[i] + scheme.old * acc[i] - scheme.carry * aux[i]


@kernel
def newton_matrix(scheme, terms, jacobian):
    """d residual / d [a; lam] at n + 1: w_I (I_acc + c_q I_q) + w_A (c_q A_q + c_v A_v)."""
    c_q, c_v = scheme.h * scheme.h * scheme.beta * scheme.new, scheme.h * scheme.gamma * scheme.new
    w_i, w_a = scheme.weight_inertial, scheme.weight_applied
    for e in range(len(jacobian)):
        jacobian[e] = w_i * (terms.I_acc[e] + c_q * terms.I_q[e]) + w_a * (c_q * terms.A_q[e] + c_v * terms.A_v[e])


@kernel
def is_finite(vector):
    """Whether no entry is infinite or not a number."""
    total = 0.0
    for i in range(len(vector)):
        total += abs(vector[i].real)
    return np.isfinite(total)


@kernel
def newton(plan, functions, inputs, scheme, weights, tolerance, most, q, v, acc, memory, outcome):
    """Iterate on [a; lam] until a correction moves nothing by more than the tolerance, or than round-off; returns the status."""
    c_q, c_v = scheme.h * scheme.h * scheme.beta * scheme.new, scheme.h * scheme.gamma * scheme.new
    terms, n_q = memory.terms, plan.n_q
    for i in range(n_q):
        q[i] = memory.q_predicted[i] + c_q * acc[i]
        v[i] = memory.v_predicted[i] + c_v * acc[i]
    for iteration in range(most):
        evaluate(plan, functions, inputs, q, v, acc, True, terms, memory.work)
        newton_matrix(scheme, terms, memory.jacobian)
        for i in range(plan.n):
            total = scheme.weight_inertial * terms.inertial[i] + scheme.weight_applied * terms.applied[i]
            memory.residual[i] = total + memory.carried[i]
        outcome.counts[2] = iteration + 1
        failed = factorize(memory.solver, plan.indptr, plan.indices, memory.jacobian)
        if failed < 0:
            failed = solve_checked(memory.solver, plan.indptr, plan.indices, memory.jacobian, memory.residual, memory.correction)
        if failed >= 0:
            outcome.counts[3] = failed
            return SINGULAR if is_finite(memory.residual) else NOT_FINITE
        before, largest, worst = outcome.correction[0], 0.0, 0
        for i in range(plan.n):
            acc[i] -= memory.correction[i]
            if i < n_q:
                q[i] -= c_q * memory.correction[i]
                v[i] -= c_v * memory.correction[i]
                size = weights[i] * abs(c_q * memory.correction[i].real)
                if not size <= largest:
                    largest, worst = size, i
        outcome.counts[3], outcome.correction[0] = worst, largest
        if not np.isfinite(largest):
            return NOT_FINITE
        stagnated = iteration > 0 and largest <= STAGNATED and largest > 0.1 * before
        if largest <= tolerance or stagnated:
            return CONVERGED
    return NOT_CONVERGED


@kernel
def add_product(indptr, indices, factor_1, values_1, factor_2, values_2, block, out):
    """out += (factor_1 values_1 + factor_2 values_2) block for compressed rows; block and out (n, n_x)."""
    for i in range(len(indptr) - 1):
        for e in range(indptr[i], indptr[i + 1]):
            value = factor_1 * values_1[e] + factor_2 * values_2[e]
            if value != 0:
                row = indices[e]
                for x in range(out.shape[1]):
                    out[i, x] += value * block[row, x]


@kernel
def sensitivity_step(plan, scheme, history, step, memory):
    """Total design derivatives at n + 1 from those at n, with the factors of the converged Jacobian."""
    terms, ptr, col = memory.terms, plan.indptr, plan.indices
    w_i, w_a = scheme.weight_inertial, scheme.weight_applied
    dq, dv, dacc = history.dq[step + 1], history.dv[step + 1], history.dacc[step + 1]
    count, after = plan.n_q * plan.n_x, step + 1
    predict(
        scheme, history.flat_dq[step], history.flat_dv[step], history.flat_dacc[step], memory.flat_daux, count,
        history.flat_dq[after], history.flat_dv[after],
    )  # fmt: skip
    load = memory.pseudo_load
    for i in range(plan.n):
        for x in range(plan.n_x):
            load[i, x] = memory.dcarried[i, x] + w_i * terms.I_x[i, x] + w_a * terms.A_x[i, x]
    add_product(ptr, col, w_i, terms.I_q, w_a, terms.A_q, dq, load)
    add_product(ptr, col, w_a, terms.A_v, 0.0, terms.A_v, dv, load)
    solve_refined_block(memory.solver, ptr, col, memory.jacobian, load, dacc)
    c_q, c_v = scheme.h * scheme.h * scheme.beta * scheme.new, scheme.h * scheme.gamma * scheme.new
    for i in range(plan.n):
        for x in range(plan.n_x):
            dacc[i, x] = -dacc[i, x]
            if i < plan.n_q:
                dq[i, x] += c_q * dacc[i, x]
                dv[i, x] += c_v * dacc[i, x]
    advance_auxiliary(scheme, history.flat_dacc[step], history.flat_dacc[after], count, memory.flat_daux)


@kernel
def carry_over(plan, scheme, memory, dq, dv, dacc):
    """The carried part of the next step's residual, and its total derivative (without it a gradient is wrong by a per cent)."""
    terms, ptr, col = memory.terms, plan.indptr, plan.indices
    c_i, c_a = scheme.carried_inertial, scheme.carried_applied
    for i in range(plan.n):
        memory.carried[i] = c_i * terms.inertial[i] + c_a * terms.applied[i]
        for x in range(plan.n_x):
            memory.dcarried[i, x] = c_i * terms.I_x[i, x] + c_a * terms.A_x[i, x]
    if plan.n_x > 0:
        add_product(ptr, col, c_i, terms.I_q, c_a, terms.A_q, dq, memory.dcarried)
        add_product(ptr, col, c_a, terms.A_v, 0.0, terms.A_v, dv, memory.dcarried)
        add_product(ptr, col, c_i, terms.I_acc, 0.0, terms.I_acc, dacc, memory.dcarried)


@kernel
def begin(plan, functions, inputs, scheme, history, memory):
    """Auxiliary acceleration and carried terms of the first step, from the consistent start."""
    for i in range(plan.n_q):
        memory.aux[i] = history.acc[0, i]
        for x in range(plan.n_x):
            memory.daux[i, x] = history.dacc[0, i, x]
    if scheme.carried_applied != 0:
        evaluate(plan, functions, inputs, history.q[0], history.v[0], history.acc[0], True, memory.terms, memory.work)
        if plan.n_x > 0:
            evaluate_design(plan, functions, inputs, history.q[0], history.v[0], history.acc[0], memory.terms, memory.work)
        carry_over(plan, scheme, memory, history.dq[0], history.dv[0], history.dacc[0])


@kernel
def refresh(plan, functions, inputs, scheme, q, v, acc, correction, memory):
    """Bring to the converged state what the rest of the step needs, and no more: residual, Jacobian, design partials."""
    relinearize = plan.n_x > 0 and correction > REUSED
    if relinearize or scheme.carried_applied != 0:
        evaluate(plan, functions, inputs, q, v, acc, relinearize, memory.terms, memory.work)
    if relinearize:
        newton_matrix(scheme, memory.terms, memory.jacobian)
        if correction > SHARP:
            factorize(memory.solver, plan.indptr, plan.indices, memory.jacobian)
    if plan.n_x > 0:
        evaluate_design(plan, functions, inputs, q, v, acc, memory.terms, memory.work)


@kernel
def integrate(plan, functions, curves, curves_x, levels, scheme, weights, tolerance, most, first, last, history, memory, outcome):
    """Steps first ... last - 1; step n goes from time n to n + 1. Stops at the first step that fails."""
    if first == 0:
        begin(plan, functions, Inputs(curves[0], curves_x[0], 1.0, levels), scheme, history, memory)
    carries = scheme.carried_applied != 0
    for step in range(first, last):
        inputs = Inputs(curves[step + 1], curves_x[step + 1], 1.0, levels)
        q, v, acc = history.q[step + 1], history.v[step + 1], history.acc[step + 1]
        predict(
            scheme,
            history.q[step],
            history.v[step],
            history.acc[step],
            memory.aux,
            plan.n_q,
            memory.q_predicted,
            memory.v_predicted,
        )
        copy(history.acc[step], acc)
        outcome.counts[1] = step
        outcome.counts[0] = newton(plan, functions, inputs, scheme, weights, tolerance, most, q, v, acc, memory, outcome)
        outcome.counts[4] += outcome.counts[2]
        if outcome.counts[0] != CONVERGED:
            return
        refresh(plan, functions, inputs, scheme, q, v, acc, outcome.correction[0], memory)
        if plan.n_x > 0:
            sensitivity_step(plan, scheme, history, step, memory)
        advance_auxiliary(scheme, history.acc[step], acc, plan.n_q, memory.aux)
        if carries:
            carry_over(plan, scheme, memory, history.dq[step + 1], history.dv[step + 1], history.dacc[step + 1])
