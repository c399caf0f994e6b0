"""Stabilised index 2 (Gear, Gupta and Leimkuhler 1985): a step that satisfies joints by positions and by velocities.

As Arnold, Bruels and Cardona (2015) put it into the generalized-alpha step, with more multipliers eta, the predictions of
`solvers.prediction` and c_q = d q_+ / d a_+, c_v = d v_+ / d a_+:

    q_+ = q_predicted + c_q (a_+ + S eta),   v_+ = v_predicted + c_v a_+,   S = W^-2 phi_q(q_n)^T
    0 = coordinates' rows at (q_+, v_+, a_+, lam),   0 = (phi_q v + phi_t) / c_v,   0 = phi(q_+) / c_q

eta is of the size of the local error, so that every positive W is as accurate. W compares coordinates as `numbering.weights` do, with
W^-2 rounded to a power of ten: a change of the design then leaves it alone, and a change of units changes it exactly as coordinates.
"""

from __future__ import annotations

from toolkit.equations.equations import Inputs
from toolkit.foundation.kernel import inner
from toolkit.linear.linear_solver import apply_inverse, factorize, solve_checked, solve_refined_block
from toolkit.solvers.transient.prediction import advance_auxiliary, predict
from toolkit.solvers.transient.scheme import by_acceleration
from toolkit.solvers.transient.staggered import add_design_change, add_state_change
from toolkit.solvers.transient.step_memory import AT_FAULT, LAST


@inner
def positions(inputs, ggl):
    """Inputs of the equations for the joints' own positions and forces."""
    return Inputs(inputs.curves, inputs.curves_x, inputs.scale, ggl.levels, inputs.inertia, True)


@inner
def begin_ggl(evaluator, plan, functions, inputs, q, v, acc, memory, ggl):
    """Compute S at the known state, and set eta = 0."""
    evaluator(plan, functions, positions(inputs, ggl), q, v, acc, True, False, ggl.terms, memory.work)
    pattern = ggl.pattern
    for k in range(len(pattern.row)):
        ggl.S[k] = ggl.metric[pattern.coordinate[k]] * ggl.terms.I_acc[pattern.upper[k]]
    ggl.eta[:] = 0


@inner
def ggl_matrix(scheme, memory, ggl):
    """Compute the matrix of the step from the base matrix in `memory.jacobian` and its terms (see `ggl_pattern`)."""
    c_q, c_v = by_acceleration(scheme)
    pattern, values, terms, S = ggl.pattern, ggl.jacobian, memory.terms, ggl.S
    bent, closing = pattern.bent, pattern.closing
    values[:] = 0
    for e in range(len(pattern.base)):
        values[pattern.base[e]] = memory.jacobian[e]
    for t in range(len(bent.place)):
        values[bent.place[t]] += c_q * (terms.I_q[bent.left[t]] + terms.A_q[bent.left[t]]) * S[bent.right[t]]
    for k in range(len(pattern.lower)):
        values[pattern.position[k]] = c_v * terms.A_v[pattern.lower[k]]
    for t in range(len(closing.place)):
        values[closing.place[t]] += c_v * terms.A_v[pattern.lower[closing.left[t]]] * S[closing.right[t]]


@inner
def factorize_ggl(scheme, memory, ggl):
    """Factor the step's matrix; results as those of `factorize`."""
    ggl_matrix(scheme, memory, ggl)
    return factorize(ggl.solver, ggl.pattern.indptr, ggl.pattern.indices, ggl.jacobian)


@inner
def solve_ggl(evaluator, plan, functions, inputs, scheme, kept, q, v, acc, memory, ggl):
    """Solve for Newton's correction of [a; lam; eta], whose first part goes to `memory.correction`.

    The factors are kept ones, or those of `memory.jacobian`.

    Returns -1, or the unknown that the equations do not determine (for eta the multiplier of the same joint).
    """
    evaluator(plan, functions, positions(inputs, ggl), q, v, acc, False, False, ggl.terms, memory.work)
    c_q, _ = by_acceleration(scheme)
    for i in range(plan.n):
        ggl.residual[i] = memory.residual[i]
        if i >= plan.n_q:
            ggl.residual[plan.n - plan.n_q + i] = ggl.terms.applied[i] / c_q
    failed = -1
    if kept:
        for i in range(len(ggl.residual)):
            ggl.correction[i] = ggl.residual[i]
        apply_inverse(ggl.solver, ggl.correction)
    else:
        pattern = ggl.pattern
        failed = factorize_ggl(scheme, memory, ggl)
        if failed < 0:
            failed = solve_checked(ggl.solver, pattern.indptr, pattern.indices, ggl.jacobian, ggl.residual, ggl.correction)
    for i in range(plan.n):
        memory.correction[i] = ggl.correction[i]
    return failed - (plan.n - plan.n_q) if failed >= plan.n else failed


@inner
def correct_ggl(plan, scheme, weights, ggl, q, outcome):
    """Subtract eta's correction, after that of [a; lam]; the size of the whole correction goes to `outcome`."""
    (c_q, _), pattern = by_acceleration(scheme), ggl.pattern
    ggl.moved[:] = 0
    for k in range(len(pattern.row)):
        ggl.moved[pattern.coordinate[k]] += ggl.S[k] * ggl.correction[plan.n + pattern.row[k]]
    for j in range(len(ggl.eta)):
        ggl.eta[j] -= ggl.correction[plan.n + j]
    for i in range(plan.n_q):
        q[i] -= c_q * ggl.moved[i]
        size = weights[i] * abs(c_q * ggl.moved[i].real)
        if not size <= outcome.correction[LAST]:
            outcome.counts[AT_FAULT], outcome.correction[LAST] = i, size


@inner
def ggl_sensitivity_step(evaluator, plan, functions, inputs, scheme, history, step, fresh, memory, ggl):
    """Compute total design derivatives at n + 1 from those at n, with the converged Jacobian, as `staggered.sensitivity_step`.

    At fixed unknowns q_+ moves with the prediction and with c_q d(S eta); the rows of positions are differentiated like the others.
    """
    pattern, terms, load, n_x = ggl.pattern, memory.terms, ggl.pseudo_load, plan.n_x
    dq, dv, dacc = history.dq[step + 1], history.dv[step + 1], history.dacc[step + 1]
    c_q, c_v = by_acceleration(scheme)
    count, after, n_lam = plan.n_q * n_x, step + 1, plan.n - plan.n_q
    predict(
        scheme, history.flat_dq[step], history.flat_dv[step], history.flat_dacc[step], memory.flat_daux, count,
        history.flat_dq[after], history.flat_dv[after],
    )  # fmt: skip
    known = positions(inputs, ggl)
    for j in range(n_lam):
        ggl.lever[plan.n_q + j] = ggl.eta[j]
    evaluator(plan, functions, known, history.q[step], history.v[step], ggl.lever, True, True, ggl.terms, memory.work)
    add_turned(plan, c_q, history.dq[step], ggl, dq)
    load[:] = 0
    add_design_change(plan, terms, 1.0, 1.0, load)
    add_state_change(plan, terms, 1.0, 1.0, dq, dv, dacc, False, memory, load)
    evaluator(plan, functions, known, history.q[after], history.v[after], history.acc[after], False, True, ggl.terms, memory.work)
    for e in range(len(plan.touched_row)):
        i, x = plan.touched_row[e], plan.touched_variable[e]
        if i >= plan.n_q:
            load[n_lam + i, x] += ggl.terms.A_x[i, x] / c_q
    for k in range(len(pattern.row)):
        entry = c_v / c_q * terms.A_v[pattern.lower[k]]
        for x in range(n_x):
            load[plan.n + pattern.row[k], x] += entry * dq[pattern.coordinate[k], x]
    solve_refined_block(ggl.solver, pattern.indptr, pattern.indices, ggl.jacobian, None, 0.0, fresh, load, ggl.change)
    for i in range(plan.n):
        for x in range(n_x):
            dacc[i, x] = -ggl.change[i, x]
            if i < plan.n_q:
                dq[i, x] += c_q * dacc[i, x]
                dv[i, x] += c_v * dacc[i, x]
    for k in range(len(pattern.row)):
        for x in range(n_x):
            dq[pattern.coordinate[k], x] -= c_q * ggl.S[k] * ggl.change[plan.n + pattern.row[k], x]
    advance_auxiliary(scheme, history.flat_dacc[step], history.flat_dacc[after], count, memory.flat_daux)


@inner
def add_turned(plan, c_q, dq_known, ggl, dq):
    """dq += c_q d(S eta) at constant eta, c_q W^-2 [(phi_q^T eta)_q dq_n + (phi_q^T eta)_x]; `ggl.terms` hold phi_q^T eta at n."""
    for i in range(plan.n_q):
        for e in range(plan.indptr[i], plan.indptr[i + 1]):
            entry, column = c_q * ggl.metric[i] * ggl.terms.I_q[e], plan.indices[e]
            if entry != 0:
                for x in range(dq.shape[1]):
                    dq[i, x] += entry * dq_known[column, x]
    for e in range(len(plan.touched_row)):
        i, x = plan.touched_row[e], plan.touched_variable[e]
        if i < plan.n_q:
            dq[i, x] += c_q * ggl.metric[i] * ggl.terms.I_x[i, x]
