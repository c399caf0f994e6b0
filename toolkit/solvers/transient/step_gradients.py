"""Sensitivities of converged steps: staggered direct differentiation forwards, the adjoint loop backwards."""

from typing import NamedTuple

import numpy as np

from toolkit.components.bodies.kernels.constant_kernel import LEFT_OUT
from toolkit.foundation.compiled.rows import add_rows, filled_up
from toolkit.foundation.kernel import inner, loop
from toolkit.linear.linear_solver import (
    LinearSolver,
    add_factored_block,
    copy_columns,
    factorize,
    linear_solver,
    solve_refined_block,
)
from toolkit.linear.sparse_analysis import LUPlan
from toolkit.solvers.transient.scheme import advance_auxiliary, by_acceleration, newton_matrix, predict, with_step
from toolkit.system.equations import (
    DesignSums,
    GatheredPlan,
    Inputs,
    Plan,
    ScratchMemory,
    Terms,
    add_up,
    allocate_terms,
    allocate_work,
    design_sums,
    gather,
)


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


class Bars(NamedTuple):
    """Derivatives of the n_r responses by what one step leaves to the next; blocks (n, n_r filled up)."""

    q: np.ndarray
    v: np.ndarray
    acc: np.ndarray  # [a; lam]
    aux: np.ndarray  # w


class AdjointMemory(NamedTuple):
    """Memory of the backward loop."""

    bars: Bars
    multiplier: np.ndarray  # (n, n_r filled up) mu of the step above
    load: np.ndarray
    jacobian: np.ndarray  # (n_entries,)
    rest: np.ndarray  # (n_entries,) the same without the factored stiffness; empty if there is none
    transposed: np.ndarray  # (n_entries,) the transpose of one of both on the same, symmetric pattern
    mixed: np.ndarray  # (n_entries,) scratch memory of `add_transposed`
    terms: Terms
    work: ScratchMemory
    solver: LinearSolver
    sums: DesignSums


def adjoint_memory(plan: Plan, gathered: GatheredPlan, lu_plan: LUPlan, weights: np.ndarray, n_r: int) -> AdjointMemory:
    """Memory of the backward loop for n_r responses."""

    def block() -> np.ndarray:
        return np.zeros((plan.n, filled_up(n_r)))

    work, apart = allocate_work(plan, float), len(plan.constant.strained) > 0
    work.care[1] = apart
    return AdjointMemory(
        Bars(block(), block(), block(), block()),
        block(),
        block(),
        np.zeros(len(plan.indices)),
        np.zeros(len(plan.indices) if apart else 0),
        np.zeros(len(plan.indices)),
        np.zeros(len(plan.indices)),
        allocate_terms(plan, float),
        work,
        linear_solver(lu_plan, weights[: plan.n_q], n_r, float),
        design_sums(gathered, plan.n_x, plan.n, len(plan.markers.frame), len(plan.markers.coordinate), n_r),
    )


@inner
def add_transposed(plan, transposition, one, factor_one, two, factor_two, block, rows, memory, out):
    """Add (factor_one A + factor_two B)^T block to `out`, in so many rows, as the others are zero.

    `one` are the values of A and `two` those of B on the pattern; blocks are (n, n_r filled up).
    """
    mixed = memory.mixed
    for e in range(plan.indptr[rows]):
        mixed[e] = factor_one * one[transposition[e]] + factor_two * two[transposition[e]]
    for i in range(rows):
        add_rows(out[i], 1.0, 1.0, mixed, plan.indices, plan.indptr[i], plan.indptr[i + 1], block)


@inner
def add_strained(plan, factor, block, memory, out):
    """Add factor times the factored stiffness times a block to `out`, where the terms lack it."""
    if memory.work.care[1] == 1:
        add_factored_block(plan.constant.strains, factor, block, memory.load, out)


@inner
def add_design(plan, scheme, levels, factor_i, factor_a, q, v, acc, block, memory, gradient):
    """gradient += (factor_i I_x + factor_a A_x)^T block, apart from what `memory.sums` gathers; gradient (n_x, n_r)."""
    terms = memory.terms
    gather(plan, memory.sums, scheme, levels, memory.work.markers, factor_i, factor_a, q, v, acc, block)
    for e in range(len(plan.touched_row)):
        i, x = plan.touched_row[e], plan.touched_variable[e]
        change = factor_i * terms.I_x[i, x] + factor_a * terms.A_x[i, x]
        for r in range(gradient.shape[1]):
            gradient[x, r] += change * block[i, r]


@inner
def add_carried(plan, scheme, levels, transposition, q, v, acc, memory, gradient):
    """Add what the residual of the step above took from this state."""
    c_i, c_a, terms, bars, above = scheme.carried_inertial, scheme.carried_applied, memory.terms, memory.bars, memory.multiplier
    add_transposed(plan, transposition, terms.I_q, c_i, terms.A_q, c_a, above, plan.n_q, memory, bars.q)
    add_strained(plan, c_a, above, memory, bars.q)
    add_transposed(plan, transposition, terms.I_acc, 0.0, terms.A_v, c_a, above, plan.n_q, memory, bars.v)
    add_transposed(plan, transposition, terms.I_acc, c_i, terms.A_v, 0.0, above, plan.n, memory, bars.acc)
    add_design(plan, scheme, levels, c_i, c_a, q, v, acc, above, memory, gradient)


@inner
def add_partials(by, bar):
    """Add the responses' own derivatives by one kind of unknowns of a step, which may have fewer rows, or none, to `bar`."""
    for i in range(by.shape[0]):
        for r in range(by.shape[1]):
            bar[i, r] += by[i, r]


@inner
def solve_step(plan, scheme, transposition, memory):
    """Solve for mu of a step; results as those of `factorize`.

    J^T mu = - (derivative of the responses by [a; lam] through everything that they move).
    """
    bars, load = memory.bars, memory.load
    c_q, c_v = scheme.h * scheme.h * scheme.beta, scheme.h * scheme.gamma
    for i in range(plan.n):
        for r in range(load.shape[1]):
            load[i, r] = -bars.acc[i, r]
            if i < plan.n_q:
                load[i, r] -= scheme.new * (bars.aux[i, r] + c_q * bars.q[i, r] + c_v * bars.v[i, r])
    apart = memory.work.care[1]
    newton_matrix(plan, scheme, memory.terms, apart, memory.jacobian, memory.rest)
    for e in range(len(transposition)):
        memory.transposed[e] = memory.jacobian[transposition[e]]
    solver, transposed = memory.solver, memory.transposed
    failed = factorize(solver, plan.indptr, plan.indices, transposed)
    if failed < 0 and apart == 1:
        for e in range(len(transposition)):
            transposed[e] = memory.rest[transposition[e]]
        strains, factor = plan.constant.strains, scheme.weight_applied * by_acceleration(scheme)[0]
        solve_refined_block(solver, plan.indptr, plan.indices, transposed, strains, factor, False, load, memory.multiplier)
    elif failed < 0:
        solve_refined_block(solver, plan.indptr, plan.indices, transposed, None, 0.0, False, load, memory.multiplier)
    return failed


@inner
def step_back(plan, scheme, ratio, transposition, memory):
    """Compute the bars of the state before from those of this one.

    `ratio` is that of the lengths of this step and the one before.
    """
    bars, terms, mu = memory.bars, memory.terms, memory.multiplier
    h, beta, gamma = scheme.h, scheme.beta, scheme.gamma
    w_i, w_a = scheme.weight_inertial, scheme.weight_applied
    add_transposed(plan, transposition, terms.I_q, w_i, terms.A_q, w_a, mu, plan.n_q, memory, bars.q)
    add_strained(plan, w_a, mu, memory, bars.q)
    add_transposed(plan, transposition, terms.I_acc, 0.0, terms.A_v, w_a, mu, plan.n_q, memory, bars.v)
    for i in range(plan.n):
        for r in range(mu.shape[1]):
            if i < plan.n_q:
                q, v = bars.q[i, r], bars.v[i, r]
                known = bars.aux[i, r] + h * h * beta * q + h * gamma * v
                aux = h * h * scheme.beta_old * q + h * scheme.gamma_old * v - scheme.carry * known
                bars.v[i, r] = scheme.keep * (v + h * q)
                bars.aux[i, r] = ratio * aux
                bars.acc[i, r] = scheme.old * known + (1 - ratio) * aux
            else:
                bars.q[i, r], bars.v[i, r], bars.aux[i, r], bars.acc[i, r] = 0.0, 0.0, 0.0, 0.0


@loop
def integrate_backwards(
    evaluator, plan, functions, curves, curves_x, lengths, ratios, levels, scheme, transposition, begins, ends, q, v, acc, by_q, by_v,
    by_acc, memory, gradient,
):  # fmt: skip
    """Add to `gradient` (n_x, n_r), and to `memory.sums`, what the design does in the steps to the given states.

    The states are those of a window, or of the whole run: `begins` if its start is the first of them, `ends` if its end is the last.
    `lengths` (n_t,), `levels` (n_t, 3) and `ratios` (n_t,) to the length before are those of the step to each state.
    `memory` carries what one window leaves to the one before, at last the derivatives by the start in `memory.bars`.

    With the bars b of q, v, acc, w at step n + 1 =: + (derivatives of the responses by them, everything else fixed), a step of
    `solvers.scheme` is differentiated backwards:

        J^T mu = - b_acc - new (b_w + h^2 beta b_q + h gamma b_v)
        b_q += (w_I I_q + w_A A_q)^T mu,  b_v += w_A A_v^T mu,  gradient += (w_I I_x + w_A A_x)^T mu
        k = b_w + h^2 beta b_q + h gamma b_v
        before:  keep (b_v + h b_q),  ratio c  (of w),  old k + (1 - ratio) c  (of acc),
                 c = h^2 beta_old b_q + h gamma_old b_v - carry k

    With the scheme `START`, of the start alone, [a; lam] are found from coordinates and velocities, whose bars it leaves.

    Returns -1, or the number of the unknown that a step does not determine.
    """
    memory.work.care[0] = LEFT_OUT
    for step in range(len(q) - 1, -1, -1):
        now, is_start = with_step(scheme, lengths[step]), begins and step == 0
        inputs = Inputs(curves[step], curves_x[step], 1.0, levels[step], scheme.inertia, False)
        if carries(scheme) or not is_start:
            evaluator(plan, functions, inputs, q[step], v[step], acc[step], True, True, memory.terms, memory.work)
        if carries(scheme) and not (ends and step == len(q) - 1):
            add_carried(plan, scheme, levels[step], transposition, q[step], v[step], acc[step], memory, gradient)
        add_partials(by_q[step], memory.bars.q)
        add_partials(by_v[step], memory.bars.v)
        add_partials(by_acc[step], memory.bars.acc)
        if not is_start:
            failed = solve_step(plan, now, transposition, memory)
            if failed >= 0:
                return failed
            w_i, w_a = scheme.weight_inertial, scheme.weight_applied
            add_design(plan, scheme, levels[step], w_i, w_a, q[step], v[step], acc[step], memory.multiplier, memory, gradient)
            step_back(plan, now, ratios[step], transposition, memory)
    if begins or scheme.h == 0:
        add_up(memory.sums)
    if begins:
        for i in range(plan.n_q):
            for r in range(gradient.shape[1]):
                memory.bars.acc[i, r] += memory.bars.aux[i, r]
    return -1
