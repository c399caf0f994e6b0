"""Sensitivities of one converged step (staggered direct differentiation, paper eqs. 40-46), and the terms that a step carries over."""

from toolkit.kernel import kernel
from toolkit.linear.linear_solver import solve_refined_block
from toolkit.solvers.prediction import advance_auxiliary, predict


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
