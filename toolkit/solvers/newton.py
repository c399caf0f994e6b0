"""Newton's iteration of one time step, with the exact Jacobian (paper, eqs. 34-37)."""

import numpy as np

from toolkit.kernel import inner
from toolkit.linear.linear_solver import factorize, solve_checked

CONVERGED, NOT_CONVERGED, SINGULAR, NOT_FINITE = 0, 1, 2, 3
STAGNATED = 1e-7
"""Correction below which Newton is content when round-off keeps it from shrinking further."""


@inner
def newton_matrix(scheme, terms, jacobian):
    """d residual / d [a; lam] at n + 1: w_I (I_acc + c_q I_q) + w_A (c_q A_q + c_v A_v)."""
    c_q, c_v = scheme.h * scheme.h * scheme.beta * scheme.new, scheme.h * scheme.gamma * scheme.new
    w_i, w_a = scheme.weight_inertial, scheme.weight_applied
    for e in range(len(jacobian)):
        jacobian[e] = w_i * (terms.I_acc[e] + c_q * terms.I_q[e]) + w_a * (c_q * terms.A_q[e] + c_v * terms.A_v[e])


@inner
def is_finite(vector):
    """Whether no entry is infinite or not a number."""
    total = 0.0
    for i in range(len(vector)):
        total += abs(vector[i].real)
    return np.isfinite(total)


@inner
def newton(evaluator, plan, functions, inputs, scheme, weights, tolerance, most, q, v, acc, memory, outcome):
    """Iterate on [a; lam] until a correction moves nothing by more than the tolerance, or than round-off; returns the status."""
    c_q, c_v = scheme.h * scheme.h * scheme.beta * scheme.new, scheme.h * scheme.gamma * scheme.new
    terms, n_q = memory.terms, plan.n_q
    for i in range(n_q):
        q[i] = memory.q_predicted[i] + c_q * acc[i]
        v[i] = memory.v_predicted[i] + c_v * acc[i]
    for iteration in range(most):
        memory.work.rough[0] = int(iteration == 0)  # a first correction is far larger than its round-off
        evaluator(plan, functions, inputs, q, v, acc, True, False, terms, memory.work)
        memory.work.rough[0] = 0
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
