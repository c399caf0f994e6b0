"""The compiled step loop: generalized-alpha with exact Newton, and the sensitivities carried along.

Per step: predict, iterate to convergence, then (with design variables) solve with the Jacobian of the converged state for all design
derivatives in one block (staggered direct differentiation, paper eqs. 40-46). Nothing here allocates.
"""

from toolkit.equations import Inputs
from toolkit.kernel import copy, inner, kernel
from toolkit.linear.linear_solver import factorize
from toolkit.solvers.newton import CONVERGED, newton, newton_matrix
from toolkit.solvers.prediction import advance_auxiliary, predict
from toolkit.solvers.staggered import carries, carry_over, sensitivity_step

REUSED, SHARP = 1e-13, 1e-7
"""Last Newton correction up to which the last Jacobian is that of the converged state (the difference is round-off), and up to which at
least its factors still serve: one refinement with the converged Jacobian squares their relative error."""


@inner
def begin(evaluator, plan, functions, inputs, scheme, history, memory):
    """Auxiliary acceleration and carried terms of the first step, from the consistent start."""
    for i in range(plan.n_q):
        memory.aux[i] = history.acc[0, i]
        for x in range(plan.n_x):
            memory.daux[i, x] = history.dacc[0, i, x]
    if carries(scheme):
        q, v, acc = history.q[0], history.v[0], history.acc[0]
        evaluator(plan, functions, inputs, q, v, acc, True, plan.n_x > 0, memory.terms, memory.work)
        carry_over(plan, scheme, memory, history.dq[0], history.dv[0], history.dacc[0])


@inner
def refresh(evaluator, plan, functions, inputs, scheme, q, v, acc, correction, memory):
    """Bring to the converged state what the rest of the step needs, and no more: residual, Jacobian, design partials.

    Returns whether the factors belong to the Jacobian.
    """
    relinearize = plan.n_x > 0 and correction > REUSED
    if plan.n_x > 0 or carries(scheme):
        evaluator(plan, functions, inputs, q, v, acc, relinearize, plan.n_x > 0, memory.terms, memory.work)
    if relinearize:
        newton_matrix(scheme, memory.terms, memory.jacobian)
        if correction > SHARP:
            factorize(memory.solver, plan.indptr, plan.indices, memory.jacobian)
    return not relinearize


@kernel
def integrate(
    evaluator, plan, functions, curves, curves_x, levels, scheme, weights, tolerance, most, begins, first, last, history, memory,
    outcome,
):  # fmt: skip
    """Steps first ... last - 1; step n goes from time n to n + 1. Stops at the first step that fails.

    `begins` if state 0 is the consistent start; otherwise `memory` holds what the step to the first state has left.
    """
    if begins:
        begin(evaluator, plan, functions, Inputs(curves[0], curves_x[0], 1.0, levels), scheme, history, memory)
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
        outcome.counts[0] = newton(
            evaluator, plan, functions, inputs, scheme, weights, tolerance, most, q, v, acc, memory, outcome
        )
        outcome.counts[4] += outcome.counts[2]
        outcome.correction[1] = max(outcome.correction[0], outcome.correction[1])
        if outcome.counts[0] != CONVERGED:
            return
        fresh = refresh(evaluator, plan, functions, inputs, scheme, q, v, acc, outcome.correction[0], memory)
        if plan.n_x > 0:
            sensitivity_step(plan, scheme, history, step, fresh, memory)
        advance_auxiliary(scheme, history.acc[step], acc, plan.n_q, memory.aux)
        if carries(scheme):
            carry_over(plan, scheme, memory, history.dq[step + 1], history.dv[step + 1], history.dacc[step + 1])
