"""Sensitivities of one converged step (staggered direct differentiation, paper eqs. 40-46), and the terms that a step carries over."""

from toolkit.foundation.compiled.rows import add_rows
from toolkit.foundation.kernel import inner
from toolkit.linear.factored_matrix import add_factored_block
from toolkit.linear.linear_solver import copy_columns, solve_refined_block
from toolkit.solvers.transient.prediction import advance_auxiliary, predict
from toolkit.solvers.transient.scheme import by_acceleration


@inner
def add_state_change(plan, terms, factor_i, factor_a, dq, dv, dacc, with_acc, memory, out):
    """out += factor_i (I_q dq + I_acc dacc) + factor_a (A_q dq + A_v dv), the term with I_acc only on request.

    dq and dv are (n_q, n_x), dacc and out (n, n_x). Where A_q lacks the factored stiffness, that is added.
    """
    I_q, A_q, mixed, moved, rate = terms.I_q, terms.A_q, memory.mixed, memory.moved, memory.rate
    for e in range(len(mixed)):
        mixed[e] = factor_i * I_q[e] + factor_a * A_q[e]
    copy_columns(dq, moved)
    copy_columns(dv, rate)
    for i in range(plan.n):
        first, last = plan.indptr[i], plan.indptr[i + 1]
        add_rows(out[i], 1.0, 1.0, mixed, plan.indices, first, last, moved)
        add_rows(out[i], 1.0, factor_a, terms.A_v, plan.indices, first, last, rate)
    if memory.work.care[1] == 1:
        add_factored_block(plan.constant.strains, factor_a, moved, rate, out)
    if with_acc:
        copy_columns(dacc, moved)
        for i in range(plan.n):
            add_rows(out[i], 1.0, factor_i, terms.I_acc, plan.indices, plan.indptr[i], plan.indptr[i + 1], moved)
        moved[plan.n_q :] = 0


@inner
def add_design_change(plan, terms, factor_i, factor_a, out):
    """out += factor_i I_x + factor_a A_x; out (n, n_x)."""
    for e in range(len(plan.touched_row)):
        i, x = plan.touched_row[e], plan.touched_variable[e]
        out[i, x] += factor_i * terms.I_x[i, x] + factor_a * terms.A_x[i, x]


@inner
def sensitivity_step(plan, scheme, history, step, fresh, memory):
    """Compute total design derivatives at n + 1 from those at n, with the converged Jacobian.

    `fresh` tells whether its factors are its own.
    """
    terms = memory.terms
    w_i, w_a = scheme.weight_inertial, scheme.weight_applied
    dq, dv, dacc = history.dq[step + 1], history.dv[step + 1], history.dacc[step + 1]
    count, after = plan.n_q * plan.n_x, step + 1
    predict(
        scheme, history.flat_dq[step], history.flat_dv[step], history.flat_dacc[step], memory.flat_daux, count,
        history.flat_dq[after], history.flat_dv[after],
    )  # fmt: skip
    load = memory.pseudo_load
    copy_columns(memory.dcarried, load)
    add_design_change(plan, terms, w_i, w_a, load)
    add_state_change(plan, terms, w_i, w_a, dq, dv, dacc, False, memory, load)
    c_q, c_v = by_acceleration(scheme)
    if memory.work.care[1] == 1:
        strains = plan.constant.strains
        solve_refined_block(memory.solver, plan.indptr, plan.indices, memory.rest, strains, w_a * c_q, fresh, load, dacc)
    else:
        solve_refined_block(memory.solver, plan.indptr, plan.indices, memory.jacobian, None, 0.0, fresh, load, dacc)
    flat_dq, flat_dv, flat_dacc = history.flat_dq[after], history.flat_dv[after], history.flat_dacc[after]
    for k in range(len(flat_dacc)):
        flat_dacc[k] = -flat_dacc[k]
    for k in range(count):
        flat_dq[k] += c_q * flat_dacc[k]
        flat_dv[k] += c_v * flat_dacc[k]
    advance_auxiliary(scheme, history.flat_dacc[step], history.flat_dacc[after], count, memory.flat_daux)


@inner
def carries(scheme):
    """Whether a step's residual needs terms of the step before."""
    return scheme.carried_inertial != 0 or scheme.carried_applied != 0


@inner
def carry_over(plan, scheme, memory, dq, dv, dacc):
    """Keep the carried part of the next step's residual, and its total derivative.

    Without the derivative a gradient is wrong by a per cent.
    """
    terms = memory.terms
    c_i, c_a = scheme.carried_inertial, scheme.carried_applied
    for i in range(plan.n):
        memory.carried[i] = c_i * terms.inertial[i] + c_a * terms.applied[i]
        for x in range(plan.n_x):
            memory.dcarried[i, x] = 0
    if plan.n_x > 0:
        add_design_change(plan, terms, c_i, c_a, memory.dcarried)
        add_state_change(plan, terms, c_i, c_a, dq, dv, dacc, True, memory, memory.dcarried)
