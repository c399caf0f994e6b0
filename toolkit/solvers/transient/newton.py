"""Newton's iteration of one time step, with the exact Jacobian (paper, eqs. 34-37), or with kept factors of an earlier one."""

from typing import NamedTuple

import numpy as np

from toolkit.components.bodies.kernels.constant_kernel import EXACT, ROUGH
from toolkit.components.bodies.kernels.spatial_floating import is_mixed
from toolkit.foundation.kernel import copy, inlined
from toolkit.linear.linear_solver import NO_REFINEMENT_NEEDED as UNREFINED_BLOCK
from toolkit.linear.linear_solver import apply_inverse, factorize, solve_checked
from toolkit.solvers.transient.ggl_step import correct_ggl, factorize_ggl, solve_ggl
from toolkit.solvers.transient.scheme import by_acceleration, mix, newton_matrix, step_ratio
from toolkit.solvers.transient.step_memory import (
    AT_FAULT,
    AWAY,
    BEND,
    BEST,
    EXPECTED,
    ITERATIONS,
    LAST,
    NEGLIGIBLE_MOVE,
    QUALITY,
    REST,
    UNCHECKED,
    UNREFINED,
)

CONVERGED, NOT_CONVERGED, SINGULAR, NOT_FINITE, REJECTED, EASY, JUMPED = range(7)
"""Status of a step. Three belong to runs with error control or without inertia: too large a local error; so small a one that the
next step may be longer; an equilibrium far off the path of quasi-static steps."""
STAGNATION_BELOW = 1e-7
"""Correction below which Newton is content when round-off keeps it from shrinking further."""
REFACTORIZE_CONTRACTION = 0.2
"""Contraction of the corrections above which kept factors are made anew: three iterations with them cost about as much."""
ROUND_OFF, ROUND_OFF_CONTRACTION = 1e-13, 0.5
"""Correction below which factors of an earlier step are not blamed for a contraction no better than this: it is round-off that does not
shrink. Those of the same step are not blamed below the tolerance."""


LARGE_FIRST_CORRECTION = 1e-6
"""A first correction beside which the round-off of stiff elastic forces does not matter, if they are summed as usual; a part of the
model size (or rad)."""
JACOBIAN_CHANGE_LIMIT = 1e-3
"""Relative change of the Jacobian by a correction up to which its factors serve for the rest of a step: a further correction by them leaves
that part of itself, and costs what the residual costs."""
OTHER_DIRECTION_FACTOR = 100.0
"""Factor by which they may leave more in another direction than that in which the change was found: it was 20 for a boom beside a
light block."""
LEAST_BELIEVED_PART = 0.5
"""Part of what a correction is known to leave that is believed at least when it has left less."""
STEPS_PER_MEASUREMENT, SURPRISING_CORRECTION = 20, 10.0
"""Steps after which what a correction leaves is measured anew; and how many times larger than in the last step a first correction has to be
to be looked into at once."""
REFINEMENT_ROUND_OFF, SINGULAR_REFINEMENT_FACTOR = 1e-14, 100.0
"""Change by a refinement that is round-off, and how many times more than the least so far tells of a singular position: kept factors leave
there what is not seen in the size of corrections. Four-bar linkages were off by up to 9e-7, with new factors there by 1e-8."""
SUDDEN_LOSS_FACTOR = 1e3
"""Factor by which sparse factors may have become worse since a refinement showed how good they are: where even that leaves no
more than NEGLIGIBLE_MOVE of the expected correction, it is not refined."""
UNREFINED_MOVE = 0.05
"""Part of the model size (or rad) that nothing moves by more than in a step, so that factors hardly change until they are looked at
again: a beam that turned 50 times in a step was off by 1e-11 with factors that were not refined."""


class Control(NamedTuple):
    """Limits by which a step is done, and by which it was a good one."""

    tolerance: float
    most: int  # iterations
    modified: bool  # whether factors are kept as long as they contract well
    thorough: bool  # whether no first correction is the last: imaginary parts of a complex step decide nothing but have to settle
    left: float  # error that kept factors may leave, see `allowed`
    largest_error: float  # local error above which a step is rejected
    easy_error: float  # local error below which the run pauses, to go on with longer steps
    foreseen: bool  # whether the history holds [a; lam] of a run beside this one, from which Newton begins


@inlined
def is_finite(vector):
    """Whether no entry is infinite or not a number."""
    total = 0.0
    for i in range(len(vector)):
        total += abs(vector[i].real)
    return np.isfinite(total)


@inlined
def place(scheme, memory, count, acc, q, v):
    """Compute coordinates and velocities that belong to accelerations."""
    c_q, c_v = by_acceleration(scheme)
    for i in range(count):
        q[i] = memory.q_predicted[i] + c_q * acc[i]
        v[i] = memory.v_predicted[i] + c_v * acc[i]


@inlined
def correct(plan, scheme, weights, memory, q, v, acc, outcome):
    """Subtract Newton's correction; its size and place go to `outcome`."""
    c_q, c_v = by_acceleration(scheme)
    largest, worst = 0.0, 0
    for i in range(plan.n):
        acc[i] -= memory.correction[i]
        if i < plan.n_q:
            q[i] -= c_q * memory.correction[i]
            v[i] -= c_v * memory.correction[i]
            size = weights[i] * abs(c_q * memory.correction[i].real)
            if not size <= largest:
                largest, worst = size, i
    outcome.counts[AT_FAULT], outcome.correction[LAST] = worst, largest


@inlined
def left_over(control, learnt, fresh, kept, iteration, before, size):
    """Estimated error after a correction: its size with the exact Jacobian, the rest of a geometric series with kept factors.

    The first correction by `fresh` factors, those of the last iteration, tells nothing of how they contract; one above the tolerance may
    be round-off that never gets below it.
    """
    if not kept or size == 0:
        return size
    rate = size / before if iteration > 0 else 1.0
    if fresh and not control.modified:
        rate = 2 * OTHER_DIRECTION_FACTOR * learnt[BEND] * learnt[AWAY] if size <= control.tolerance else 1.0
    return size * rate / (1 - rate) if rate < 1 else np.inf


@inlined
def allowed(control, scheme, kept):
    """Error that a step may leave.

    With the exact Jacobian it is the tolerance, which its own quadratic convergence undercuts by far.

    What kept factors leave has one sign for many steps. An error e in q is one of about e / h^2 in the acceleration, which moves bodies by
    (T / h)^2 e until the end T of the run: left = allowed / T^2 bounds that. Without inertia no step inherits it, but forces are stiffness
    times e: left is that e. Factors that were made in the same step leave what new ones leave, no more than round-off.
    """
    if not kept:
        return control.tolerance
    if not control.modified:
        return NEGLIGIBLE_MOVE
    return min(control.tolerance, control.left * scheme.h * scheme.h if scheme.inertia else control.left)


@inlined
def learn_bend(learnt, before, size):
    """Learn what a correction by the exact Jacobian leaves, as a multiple of its square, from two that follow each other.

    It depends on their direction (by forces of joints on light bodies a thousandfold), so that less than is known is believed by half.
    """
    learnt[BEND] = max(max(size, NEGLIGIBLE_MOVE) / (before * before), LEAST_BELIEVED_PART * learnt[BEND])
    learnt[UNCHECKED] = 0


@inlined
def leaves_nothing(learnt, iteration, size):
    """Whether the exact Jacobian leaves no more than round-off after a correction, by what the last ones left."""
    if iteration == 0 and (learnt[UNCHECKED] >= STEPS_PER_MEASUREMENT or size > SURPRISING_CORRECTION * learnt[EXPECTED]):
        return False
    return learnt[BEND] > 0 and learnt[BEND] * size * size <= NEGLIGIBLE_MOVE


@inlined
def serves_on(control, learnt, size):
    """Whether the factors of the exact Jacobian serve for the next correction too, by what corrections of that size have left."""
    return not control.thorough and learnt[BEND] > 0 and 2 * learnt[BEND] * size <= JACOBIAN_CHANGE_LIMIT


@inlined
def newton(evaluator, plan, functions, inputs, scheme, weights, control, q, v, acc, memory, ggl, outcome):
    """Iterate on [a; lam] until what is left is allowed (see `allowed`), or round-off; returns the status.

    Where `ggl` is active on [a; lam; eta], see `ggl_step`.
    """
    copy(acc, memory.guess)
    place(scheme, memory, plan.n_q, acc, q, v)
    terms = mix(plan.markers.frames, plan, scheme, ggl, memory)
    mixed = is_mixed(plan.markers.frames, memory.work.floating)
    trusted, kept = control.modified and step_ratio(scheme.h, memory.kept[0]) == 1, True
    learnt, stiff, rough = memory.learnt, len(plan.constant.stiff_row) > 0, False
    steady = not ggl.active and not control.modified
    for iteration in range(control.most):
        keepable = not control.modified or learnt[QUALITY] <= SINGULAR_REFINEMENT_FACTOR * learnt[BEST]
        kept, exact_before = trusted and memory.kept[0] > 0 and keepable, not kept
        rough_before = rough
        # a first correction that is not the last is far larger than its round-off
        rough = stiff and iteration == 0 and not 0 < learnt[EXPECTED] <= LARGE_FIRST_CORRECTION
        memory.work.care[0] = ROUGH if rough else EXACT
        evaluator(plan, functions, inputs, q, v, acc, not kept, False, terms, memory.work)
        memory.work.care[0] = EXACT
        for i in range(plan.n):
            total = scheme.weight_inertial * memory.terms.inertial[i] + scheme.weight_applied * memory.terms.applied[i]
            memory.residual[i] = total + memory.carried[i]
        outcome.counts[ITERATIONS] = iteration + 1
        if not kept:
            memory.kept[0] = scheme.h
        if not (kept or mixed):
            newton_matrix(plan, scheme, memory.terms, memory.work.care[1], memory.jacobian, memory.rest)
        if not ggl.active:
            blind = (
                iteration == 0
                and not (control.thorough or control.modified)
                and (plan.n_x == 0 or memory.solver.quality[0] > UNREFINED_BLOCK)
                and needs_no_refinement(learnt)
                and moves_gently(plan, scheme, weights, v)
            )
            failed = solve(plan, kept, blind, memory)
        else:
            failed = solve_ggl(evaluator, plan, functions, inputs, scheme, kept, q, v, acc, memory, ggl)
        if failed >= 0:
            outcome.counts[AT_FAULT] = failed
            return SINGULAR if is_finite(memory.residual) else NOT_FINITE
        before = outcome.correction[LAST]
        correct(plan, scheme, weights, memory, q, v, acc, outcome)
        if ggl.active:
            correct_ggl(plan, scheme, weights, ggl, q, outcome)
        size = outcome.correction[LAST]
        outcome.correction[REST] = size
        learnt[AWAY] = learnt[AWAY] + size if kept else size
        if kept and iteration > 0 and not size <= REFACTORIZE_CONTRACTION * before:
            if ROUND_OFF_CONTRACTION * before < size <= (control.tolerance if steady else ROUND_OFF):
                return CONVERGED
            trusted, steady = False, False  # for the rest of this step
            if not (size <= before or size <= control.tolerance):
                copy(memory.guess, acc)
                if ggl.active:
                    ggl.eta[:] = 0
                place(scheme, memory, plan.n_q, acc, q, v)
            continue
        if not np.isfinite(size):
            return NOT_FINITE
        if iteration == 0 and control.thorough:
            continue
        if exact_before and not (kept and control.modified) and before > (LARGE_FIRST_CORRECTION if rough_before else 0.0):
            learn_bend(learnt, before, size)
        stagnated = not kept and exact_before and size <= STAGNATION_BELOW and size > 0.1 * before
        if stagnated or (
            not rough
            and left_over(control, learnt, exact_before, kept, iteration, before, size) <= allowed(control, scheme, kept)
        ):
            return CONVERGED
        if not ggl.active and not (kept or rough or control.thorough) and leaves_nothing(learnt, iteration, size):
            learnt[UNCHECKED] += 1
            outcome.correction[REST] = learnt[BEND] * size * size
            return CONVERGED
        trusted = trusted or (steady and not kept and serves_on(control, learnt, size))
    return NOT_CONVERGED


@inlined
def needs_no_refinement(learnt):
    """Whether new factors leave nothing of the correction that is expected, judged by the last ones that were looked at.

    Gradients are not so patient: they take every digit of the factors, and are refined themselves unless these are known to be good.
    """
    if learnt[QUALITY] == 0 or learnt[UNREFINED] >= STEPS_PER_MEASUREMENT:
        return False
    return learnt[EXPECTED] > 0 and SUDDEN_LOSS_FACTOR * learnt[QUALITY] * learnt[EXPECTED] <= NEGLIGIBLE_MOVE


@inlined
def moves_gently(plan, scheme, weights, v):
    """Whether no coordinate moves far in the step, by the velocities at its end."""
    largest = 0.0
    for i in range(plan.n_q):
        largest = max(largest, weights[i] * abs(scheme.h * v[i].real))
    return largest <= UNREFINED_MOVE


@inlined
def solve(plan, kept, blind, memory):
    """Solve for Newton's correction with kept factors, or with those of the Jacobian.

    Returns -1, or the unknown that it does not determine.

    A `blind` one is not refined, if its factors are sparse.
    """
    solver, learnt = memory.solver, memory.learnt
    failed = -1 if kept else factorize(solver, plan.indptr, plan.indices, memory.jacobian)
    if failed >= 0:
        return failed
    if kept or (blind and solver.mode[0] == 0):
        copy(memory.residual, memory.correction)
        apply_inverse(solver, memory.correction)
        learnt[UNREFINED] += 1
        return -1
    failed = solve_checked(solver, plan.indptr, plan.indices, memory.jacobian, memory.residual, memory.correction)
    learnt[QUALITY], learnt[UNREFINED] = max(solver.quality[0], NEGLIGIBLE_MOVE) if solver.mode[0] == 0 else 0.0, 0
    if learnt[QUALITY] > 0:
        best = max(learnt[QUALITY], REFINEMENT_ROUND_OFF)
        learnt[BEST] = min(best, learnt[BEST]) if learnt[BEST] > 0 else best
    return failed


@inlined
def factorize_step(plan, scheme, memory, ggl):
    """Factor the step's matrix, from the Jacobian; results as those of `factorize`."""
    if ggl.active:
        return factorize_ggl(scheme, memory, ggl)
    return factorize(memory.solver, plan.indptr, plan.indices, memory.jacobian)
