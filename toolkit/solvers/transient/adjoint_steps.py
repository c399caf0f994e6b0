"""The compiled backward loop: derivatives of responses by the design, from the last step to the first, one linear solve per step."""

from typing import NamedTuple

import numpy as np

from toolkit.bodies.kernels.constant_kernel import LEFT_OUT
from toolkit.equations.design_sums import DesignSums, GatheredPlan, add_up, design_sums, gather
from toolkit.equations.equations import Inputs, Plan, Terms, Work, allocate_terms, allocate_work
from toolkit.foundation.compiled.rows import add_rows, filled_up
from toolkit.foundation.kernel import inner, loop
from toolkit.linear.factored_matrix import add_factored_block
from toolkit.linear.linear_solver import LinearSolver, factorize, linear_solver, solve_refined_block
from toolkit.linear.sparse_analysis import LUPlan
from toolkit.solvers.transient.scheme import by_acceleration, with_step
from toolkit.solvers.transient.staggered import carries
from toolkit.solvers.transient.step_matrix import newton_matrix


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
    work: Work
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
