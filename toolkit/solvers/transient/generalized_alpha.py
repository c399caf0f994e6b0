"""The compiled step loop: generalized-alpha with Newton's iteration, and the sensitivities carried along.

Per step: predict, iterate to convergence, then (with design variables) solve with the Jacobian of the converged state for all design
derivatives in one block (staggered direct differentiation, paper eqs. 40-46). Nothing here allocates.
"""

from toolkit.components.bodies.kernels.constant_kernel import EXACT, LEFT_OUT
from toolkit.foundation.kernel import inlined, loop
from toolkit.linear.linear_solver import cheaper_anew
from toolkit.solvers.transient.ggl_step import begin_ggl, ggl_matrix, ggl_sensitivity_step
from toolkit.solvers.transient.newton import CONVERGED, EASY, JUMPED, REJECTED, factorize_step, newton
from toolkit.solvers.transient.scheme import advance_auxiliary, newton_matrix, predict, rescale_auxiliary, step_ratio, with_step
from toolkit.solvers.transient.step_gradients import carries, carry_over, sensitivity_step
from toolkit.solvers.transient.step_memory import (
    ALL_ITERATIONS,
    AWAY,
    BEND,
    FITTED,
    ITERATIONS,
    LARGEST,
    LARGEST_ERROR,
    LAST_ERROR,
    LATE_ERROR,
    ORDER,
    REST,
    STATUS,
    STEP,
    forget_trend,
    guess,
    learn_trend,
)
from toolkit.system.equations import Inputs

REUSE_FACTORS_BELOW, JACOBIAN_CHANGE_LIMIT = 1e-10, 1e-6
"""Way from where the factors were made up to which they still serve, also where the relative change of the Jacobian is no more
than JACOBIAN_CHANGE_LIMIT by what a correction of that size leaves: one refinement with the Jacobian of the converged state squares
that. Where new factors cost less, they are made. The Jacobian itself is that of the converged state after any correction, which is one
of its c_q-th part in accelerations, and the inertial terms depend on these: after one of 1e-13 the spin of a slender beam about itself
had derivatives wrong by 6e-6."""
SAME_QUALITY_BELOW = 1e-4
"""Way up to which new factors are as good as the old ones, whose quality is known: it tells how far pivots are from
zero, not the digits of the matrix."""
LARGEST_STRAYING, STRAYING_PART = 0.05, 1.0
"""A quasi-static step may end this far (a part of the model size, or rad) from where the step before points to, and this part of the
way there; further off it has left the path of equilibria."""
REMEMBERED_ERROR_PART = 0.8
"""Part of the local error before that is remembered from step to step: in an oscillation the estimate passes through zero."""


@inlined
def begin(evaluator, plan, functions, inputs, scheme, history, memory):
    """Set the auxiliary acceleration and the carried terms of the first step, from the consistent start."""
    memory.span[0] = 0
    memory.learnt[:] = 0
    forget_trend(memory)
    for i in range(plan.n_q):
        memory.aux[i] = history.acc[0, i]
        for x in range(plan.n_x):
            memory.daux[i, x] = history.dacc[0, i, x]
    if carries(scheme):
        q, v, acc = history.q[0], history.v[0], history.acc[0]
        evaluator(plan, functions, inputs, q, v, acc, True, plan.n_x > 0, memory.terms, memory.work)
        carry_over(plan, scheme, memory, history.dq[0], history.dv[0], history.dacc[0])


@inlined
def foresee(plan, scheme, foreseen, history, step, memory):
    """Predict coordinates and velocities, and make a first guess of [a; lam], unless it is `foreseen`."""
    ratio = step_ratio(scheme.h, memory.span[0])
    if ratio != 1:
        rescale_auxiliary(ratio, history.acc[step], plan.n_q, memory.aux)
        rescale_auxiliary(ratio, history.flat_dacc[step], plan.n_q * plan.n_x, memory.flat_daux)
    memory.span[0] = scheme.h
    q, v, acc = history.q[step], history.v[step], history.acc[step + 1]
    predict(scheme, q, v, history.acc[step], memory.aux, plan.n_q, memory.q_predicted, memory.v_predicted)
    if not foreseen:
        guess(plan, ratio, memory, history.acc[step], acc)
    if not scheme.inertia:
        for i in range(plan.n_q):
            acc[i] = v[i] / scheme.h


@inlined
def local_error(plan, scheme, weights, history, step, memory):
    """Estimated error that one step made in q, a part of the model size or in rad: error h^2 (w_+ - w_n), see `scheme`."""
    h, largest, before, after = scheme.h, 0.0, history.acc[step], history.acc[step + 1]
    for i in range(plan.n_q):
        if scheme.inertia:
            w, w_new = memory.aux[i], scheme.new * after[i] + scheme.old * before[i] - scheme.carry * memory.aux[i]
        else:
            w, w_new = history.v[step, i] / h, history.v[step + 1, i] / h
        largest = max(largest, weights[i] * abs((w_new - w).real))
    return abs(scheme.error) * h * h * largest


@inlined
def strayed(plan, scheme, weights, history, step):
    """Whether a quasi-static step ends far from where the step before points to."""
    off, way = 0.0, 0.0
    for i in range(plan.n_q):
        ahead = scheme.h * history.v[step, i]
        way = max(way, weights[i] * abs(ahead.real))
        off = max(off, weights[i] * abs((history.q[step + 1, i] - history.q[step, i] - ahead).real))
    return off > LARGEST_STRAYING + STRAYING_PART * way


@inlined
def judge(plan, scheme, weights, control, history, step, memory, outcome):
    """Whether a converged step is good enough: CONVERGED, REJECTED or JUMPED."""
    outcome.correction[LAST_ERROR] = local_error(plan, scheme, weights, history, step, memory)
    if not scheme.inertia and strayed(plan, scheme, weights, history, step):
        return JUMPED
    return CONVERGED if outcome.correction[LAST_ERROR] <= control.largest_error else REJECTED


@inlined
def refresh(evaluator, plan, functions, inputs, scheme, control, q, v, acc, away, memory, ggl):
    """Bring to the converged state what the rest of the step needs, and no more: residual, Jacobian, design partials.

    The state is `away` from where the factors were made. Returns whether they belong to the Jacobian, and are as good as Newton's last
    refinement has shown.
    """
    still = not control.modified and away == 0
    if plan.n_x > 0 or carries(scheme):
        linearize = plan.n_x > 0 and (ggl.active or not still)
        memory.work.care[0] = EXACT if carries(scheme) else LEFT_OUT
        evaluator(plan, functions, inputs, q, v, acc, linearize, plan.n_x > 0, memory.terms, memory.work)
        memory.work.care[0] = EXACT
    if plan.n_x > 0 and not still:
        newton_matrix(plan, scheme, memory.terms, memory.work.care[1], memory.jacobian, memory.rest)
        changed = 2 * memory.learnt[BEND] * away  # of the Jacobian
        near = not control.modified and (away <= REUSE_FACTORS_BELOW or 0 < changed <= JACOBIAN_CHANGE_LIMIT)
        known = not ggl.active and not control.modified and memory.solver.mode[0] == 0
        if not near or (known and cheaper_anew(memory.solver, len(memory.jacobian), plan.n_x)):
            factorize_step(plan, scheme, memory, ggl)
            memory.kept[0] = scheme.h
            return known and away <= SAME_QUALITY_BELOW
        if ggl.active:
            ggl_matrix(scheme, memory, ggl)
    return still


@loop
def integrate(
    evaluator, plan, functions, curves, curves_x, lengths, levels, scheme, weights, control, begins, first, last, history, memory,
    ggl, outcome,
):  # fmt: skip
    """Take steps first ... last - 1, where step n goes from time n to n + 1, over lengths[n].

    The loop stops at the first step that is not CONVERGED.

    `begins` if state 0 is the consistent start; otherwise `memory` holds what the step to the first state has left. An EASY step is
    accepted, all others at which the loop stops are not. `ggl` is the memory of stabilised index 2, idle in other formulations: one loop
    serves all.
    """
    memory.kept[0] = 0
    if begins:
        inputs = Inputs(curves[0], curves_x[0], 1.0, levels[0], scheme.inertia, False)
        begin(evaluator, plan, functions, inputs, scheme, history, memory)
    for step in range(first, last):
        now = with_step(scheme, lengths[step])
        inputs = Inputs(curves[step + 1], curves_x[step + 1], 1.0, levels[step], scheme.inertia, False)
        q, v, acc = history.q[step + 1], history.v[step + 1], history.acc[step + 1]
        outcome.counts[STEP] = step
        while True:
            foresee(plan, now, control.foreseen, history, step, memory)
            if ggl.active:
                begin_ggl(evaluator, plan, functions, inputs, history.q[step], history.v[step], history.acc[step], memory, ggl)
            outcome.counts[STATUS] = newton(
                evaluator, plan, functions, inputs, now, weights, control, q, v, acc, memory, ggl, outcome
            )
            outcome.counts[ALL_ITERATIONS] += outcome.counts[ITERATIONS]
            if outcome.counts[STATUS] == CONVERGED or (memory.learnt[ORDER] == 0 and memory.learnt[FITTED] == 0):
                break
            forget_trend(memory)
        if outcome.counts[STATUS] == CONVERGED:
            outcome.counts[STATUS] = judge(plan, now, weights, control, history, step, memory, outcome)
        if outcome.counts[STATUS] != CONVERGED:
            return
        outcome.correction[LARGEST] = max(outcome.correction[REST], outcome.correction[LARGEST])
        outcome.correction[LARGEST_ERROR] = max(outcome.correction[LAST_ERROR], outcome.correction[LARGEST_ERROR])
        fresh = refresh(evaluator, plan, functions, inputs, now, control, q, v, acc, memory.learnt[AWAY], memory, ggl)
        if plan.n_x > 0:
            if ggl.active:
                ggl_sensitivity_step(evaluator, plan, functions, inputs, now, history, step, fresh, memory, ggl)
            else:
                sensitivity_step(plan, now, history, step, fresh, memory)
        advance_auxiliary(now, history.acc[step], acc, plan.n_q, memory.aux)
        learn_trend(plan, now, weights, history.acc[step], acc, memory)
        if carries(scheme):
            carry_over(plan, now, memory, history.dq[step + 1], history.dv[step + 1], history.dacc[step + 1])
        outcome.correction[LATE_ERROR] = max(
            outcome.correction[LAST_ERROR], REMEMBERED_ERROR_PART * outcome.correction[LATE_ERROR]
        )
        if outcome.correction[LATE_ERROR] < control.easy_error:
            outcome.counts[STATUS] = EASY
            return
