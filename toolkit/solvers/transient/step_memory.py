"""Memory of the step loop, and the first guess of a step from what the last steps left there.

Multiples of the last differences that would have guessed the last steps best: for motions with vibrations that steps barely resolve.

With the backward differences d1, d2, ... behind a step the change of [a; lam] in the next one is guessed as c1 d1 + c2 d2 + ... . A motion
of a few frequencies has constants c with which this is exact, however large they are in a step; a polynomial has c = 1. The c of the
next step are those of the least squares

    minimise  sum over steps n of  MISS_WEIGHT_DECAY^-n |change_n - sum_k c_k d_k,n|^2,   each coordinate in parts of the model size.

The polynomials of `extrapolation` take less time; so this is done as long as they miss by what costs a further correction.

First guess of a step's accelerations and multipliers: the way they went in the last steps, continued.

With the backward differences d1, d2, ... of [a; lam] behind the last step the guesses of order 0, 1, 2, ... are a_n, a_n + d1,
a_n + d1 + d2, ... A smooth motion makes each of them better than the one before by a factor of the size of the step, a coarse or
sudden one makes it worse; so the order of the next step is the one that would have been best in the last, among that of the last
and its neighbours. Where even that costs a further correction, other multiples of the differences are fitted, see `fit_trend`.
"""

from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.compiled.rows import LANES, add_to_each, filled_up
from toolkit.foundation.kernel import inlined, inner
from toolkit.linear.linear_solver import LinearSolver, cleared, linear_solver
from toolkit.linear.sparse_analysis import LUPlan
from toolkit.solvers.transient.scheme import by_acceleration
from toolkit.system.equations import Plan, ScratchMemory, Terms, allocate_terms, allocate_work
from toolkit.system.system import System

HIGHEST_ORDER = 6
"""Differences that guesses are made of. In a chain of 30 rods polynomials of order 2 miss by 7e-9, of 4 by 9e-11, of 6 by 5e-12, after
which one correction leaves nothing; a beam that vibrates by 0.7 rad in a step is missed by 5e-6 by every polynomial, and by 5e-6, 1e-7
and 5e-8 where 3, 4 and 6 differences are fitted."""
MISS_WEIGHT_DECAY = 0.5
"""Weight of a step's misses, in parts of that of the step after it."""
DEPENDENT_DIFFERENCES = 1e-13
"""Part of its own square that holds a multiple at zero where differences depend on each other to round-off."""


@inner
def fit_trend(n_q, scale, weights, change, memory):
    """Learn from an accepted step, whose `change` (n,) of [a; lam] is known.

    Returns by how much the multiples before it missed that.

    `memory.trend` are the differences behind the step before.
    """
    trend, fitted, rows, sums, miss = memory.trend, memory.fitted, memory.fit_rows, memory.fit_sums, 0.0
    for i in range(n_q):
        size = scale * weights[i]
        rows[i, HIGHEST_ORDER] = rest = size * change[i].real
        for k in range(HIGHEST_ORDER):
            each = size * trend[k, i].real
            rows[i, k] = memory.fit_columns[k, i] = each
            rest -= fitted[k] * each
        miss = max(miss, abs(rest))
    for k in range(HIGHEST_ORDER):
        for j in range(LANES):
            sums[k, j] *= MISS_WEIGHT_DECAY
    flat = rows.reshape(-1)
    for k in range(0, HIGHEST_ORDER, 3):
        add_to_each((sums[k], sums[k + 1], sums[k + 2]), memory.fit_columns[k : k + 3], n_q, flat, 0, LANES)
    solve_fit(sums, memory.fit_root, fitted)
    return miss


@inner
def solve_fit(sums, root, fitted):
    """Multiples c from their normal equations, S c = r with [S, r] in `sums`, by Cholesky's factors of D S D +
    DEPENDENT_DIFFERENCES, D^-2 = diag S."""
    for k in range(HIGHEST_ORDER):
        for j in range(k + 1):
            both = np.sqrt(sums[k, k]) * np.sqrt(sums[j, j])
            entry = sums[k, j] / both if both > 0 else 0.0
            for m in range(j):
                entry -= root[k, m] * root[j, m]
            if j < k:
                root[k, j] = entry / root[j, j]
            else:
                root[k, k] = np.sqrt(max(entry, 0.0) + DEPENDENT_DIFFERENCES)
    for k in range(HIGHEST_ORDER):
        size = np.sqrt(sums[k, k])
        entry = sums[k, HIGHEST_ORDER] / size if size > 0 else 0.0
        for m in range(k):
            entry -= root[k, m] * fitted[m]
        fitted[k] = entry / root[k, k]
    for k in range(HIGHEST_ORDER - 1, -1, -1):
        for m in range(k + 1, HIGHEST_ORDER):
            fitted[k] -= root[m, k] * fitted[m]
        fitted[k] /= root[k, k]
    for k in range(HIGHEST_ORDER):
        size = np.sqrt(sums[k, k])
        fitted[k] = fitted[k] / size if size > 0 else 0.0


@inner
def beside(n_q, scale, weights, order, memory):
    """Distance of the next guess by the multiples from that of a polynomial of some order."""
    largest = 0.0
    for i in range(n_q):
        apart = 0.0
        for k in range(HIGHEST_ORDER):
            apart += (memory.fitted[k] - (1.0 if k < order else 0.0)) * memory.trend[k, i].real
        largest = max(largest, scale * weights[i] * abs(apart))
    return largest


@inner
def forget_fit(memory):
    """Forget the fit of the last steps, as if no step had been seen."""
    memory.fitted[:] = 0
    memory.fit_sums[:] = 0


ORDER, EXPECTED, BEND, UNCHECKED, AWAY, QUALITY, UNREFINED, BEST, FITTING, FITTED = range(10)
"""Places in `Memory.learnt`: order of the next guess; the correction that it would have needed in the last step, 0 if unknown; what a
correction leaves in parts of its square, for how many steps Newton has not looked, and by how much it has moved since the factors were
made; what the last refinement changed in parts of the correction, 0 if unknown, how many corrections were not refined since,
and the least change so far; see `newton`. For how many steps multiples of differences will still be fitted, or minus the number of steps
that would have needed it; and whether the next guess is made of those."""
NEGLIGIBLE_MOVE = 1e-15
"""Part of the model size (or rad) that no step feels: some roundings of it, which is what last corrections of flexible bodies consist
of."""
STEPS_BEFORE_FITTING, STEPS_OF_FITTING = 10, 20
"""Steps that need multiples before they are fitted, as a short run does not get back what that costs; and steps for which they are fitted
after the last that needed it."""
LARGEST_GUESS_MISS = 1e-4
"""Part of the model size (or rad) by which a guess of higher order may miss: where steps are coarse the equations have several
solutions, and the one next to the last state is meant. Nor is a fitted one this far from that of the best order."""
HIGHER_ORDER_GAIN = 0.5
"""Part of the miss of one order that the next has to undercut: round-off alone is no trend, its differences grow with the order."""


@inlined
def forget_trend(memory):
    """Forget the trend of the last steps, as at the start of a run.

    That is also done where the last steps have misled Newton.
    """
    memory.trend[:] = 0
    memory.learnt[ORDER], memory.learnt[EXPECTED], memory.learnt[FITTING], memory.learnt[FITTED] = 0, 0, 0, 0
    forget_fit(memory)


@inlined
def guess(plan, ratio, memory, before, acc):
    """Put a first guess of [a; lam] into `acc`, from those of the step `before`; `ratio` is that of the lengths of both steps."""
    trend, order, power = memory.trend, int(memory.learnt[ORDER]), ratio
    if ratio != 1:
        memory.learnt[EXPECTED], memory.learnt[FITTING], memory.learnt[FITTED] = 0, 0, 0
        for k in range(HIGHEST_ORDER):
            for i in range(plan.n):
                trend[k, i] *= power
            power *= ratio
    for i in range(plan.n):
        acc[i] = before[i]
    fitted = memory.learnt[FITTED] > 0
    for k in range(HIGHEST_ORDER if fitted else order):
        factor = memory.fitted[k] if fitted else 1.0
        for i in range(plan.n):
            acc[i] += factor * trend[k, i]


@inlined
def learn_trend(plan, scheme, weights, before, acc, memory):
    """Take up the differences behind an accepted step, and the order that would have been best for it."""
    (c_q, _), trend, change, learnt = by_acceleration(scheme), memory.trend, memory.guess, memory.learnt
    lowest = max(int(learnt[ORDER]) - 1, 0)
    order, best = 0, 0.0
    for i in range(plan.n):
        change[i] = acc[i] - before[i]
    fitting = learnt[FITTING] > 0
    fit_missed = fit_trend(plan.n_q, c_q, weights, change, memory) if fitting else 0.0
    for k in range(HIGHEST_ORDER + 1):
        if lowest <= k <= lowest + 2:
            miss = 0.0
            for i in range(plan.n_q):
                miss = max(miss, weights[i] * abs(change[i].real))
            miss *= c_q
            if k == 0 or miss < min(HIGHER_ORDER_GAIN * best, LARGEST_GUESS_MISS) or (k == lowest and miss < LARGEST_GUESS_MISS):
                order, best = k, miss
        if k < HIGHEST_ORDER:
            for i in range(plan.n):
                behind = trend[k, i]
                trend[k, i] = change[i]
                change[i] -= behind
    learnt[ORDER], learnt[EXPECTED], learnt[FITTED] = order, best, 0
    if 0 < best < LARGEST_GUESS_MISS and learnt[BEND] * best * best > NEGLIGIBLE_MOVE:
        if not fitting and learnt[FITTING] > -STEPS_BEFORE_FITTING:
            learnt[FITTING] -= 1
        else:
            if not fitting:
                forget_fit(memory)
            learnt[FITTING] = STEPS_OF_FITTING
    elif fitting:
        learnt[FITTING] -= 1
    if (
        fitting
        and fit_missed < min(HIGHER_ORDER_GAIN * best, LARGEST_GUESS_MISS)
        and beside(plan.n_q, c_q, weights, order, memory) < LARGEST_GUESS_MISS
    ):
        learnt[EXPECTED], learnt[FITTED] = fit_missed, 1


class History(NamedTuple):
    """States at all times; q and v are padded to n, acc = [a; lam], leading d: total design derivative, last axis n_x."""

    q: np.ndarray  # (n_t, n)
    v: np.ndarray
    acc: np.ndarray
    dq: np.ndarray  # (n_t, n_q, n_x)
    dv: np.ndarray
    dacc: np.ndarray  # (n_t, n, n_x)
    flat_dq: np.ndarray  # (n_t, n_q n_x) the same memory, for formulas that serve vectors and blocks alike
    flat_dv: np.ndarray
    flat_dacc: np.ndarray


class Memory(NamedTuple):
    """Memory of the step loop: what one step leaves to the next, and scratch memory."""

    aux: np.ndarray  # (n,) auxiliary acceleration w
    daux: np.ndarray  # (n, n_x)
    flat_daux: np.ndarray  # (n n_x,) the same memory
    carried: np.ndarray  # (n,) carried part of the residual
    dcarried: np.ndarray  # (n, n_x filled up)
    pseudo_load: np.ndarray
    moved: np.ndarray  # scratch memory of `add_state_change`, as the next one; zero in the rows of multipliers
    rate: np.ndarray
    span: np.ndarray  # (1,) length of the step that aux belongs to, 0 at the start
    kept: np.ndarray  # (1,) length of the step that the factors belong to, 0 if they are of no use
    trend: np.ndarray  # (HIGHEST_ORDER, n) differences of [a; lam] behind the last step, see `extrapolation`
    fitted: np.ndarray  # (HIGHEST_ORDER,) multiples of them that would have guessed the last steps best, see `fit_trend`
    fit_sums: np.ndarray  # (HIGHEST_ORDER, LANES) normal equations of these
    fit_rows: np.ndarray  # (n_q, LANES) scratch memory of a fit, as the next ones
    fit_columns: np.ndarray  # (HIGHEST_ORDER, n_q)
    fit_root: np.ndarray  # (HIGHEST_ORDER, HIGHEST_ORDER)
    learnt: np.ndarray  # (10,) by `extrapolation.ORDER` and its neighbours
    guess: np.ndarray  # (n,) first guess of [a; lam]
    q_predicted: np.ndarray
    v_predicted: np.ndarray
    residual: np.ndarray
    correction: np.ndarray
    jacobian: np.ndarray  # (n_entries,)
    rest: np.ndarray  # (n_entries,) the same without the factored stiffness; empty without that or gradients
    mixed: np.ndarray  # (n_entries,) scratch memory of `add_state_change`
    terms: Terms
    whole: Terms  # with the jacobian in the place of all derivatives by the state, see `scheme.mix`
    work: ScratchMemory
    solver: LinearSolver


STATUS, STEP, ITERATIONS, AT_FAULT, ALL_ITERATIONS = range(5)
"""Places in `LoopReport.counts`: fate of the last step, its number, its Newton iterations, the unknown at fault; those of all steps."""
LAST, LARGEST, LAST_ERROR, LATE_ERROR, LARGEST_ERROR, REST = range(6)
"""Places in `LoopReport.correction`: Newton's last correction, the largest that a step was content with; the last local error, the largest
of late, the largest of all steps; the last correction, or what it left by estimate where that is why Newton stopped."""


class LoopReport(NamedTuple):
    """Report of the loop on its steps."""

    counts: np.ndarray  # (5,) by `STATUS` and its neighbours
    correction: np.ndarray  # (6,) by `LAST` and its neighbours, relative to the model size


def taken_memory(system: System, apart: bool) -> Memory:
    """Memory of the loop, one that a run has given back or a new one.

    `apart` tells whether it may keep the factored stiffness apart.
    """
    plan, weights = system.plan, system.weights[: system.n_q]
    memory = system.scratch(Memory, lambda: allocate_memory(plan, system.lu_plan, weights.copy(), system.dtype))
    parts: list[Any] = list(memory)
    while parts:
        part = parts.pop()
        if isinstance(part, np.ndarray):
            part.fill(0)
        elif isinstance(part, tuple) and not isinstance(part, ScratchMemory | LinearSolver):
            parts.extend(part)
    cleared(memory.solver, weights)
    memory.work.care[1] = apart and len(memory.rest) > 0
    return memory  # in `work` states are evaluated one after the other anyway


def allocate_memory(plan: Plan, lu_plan: LUPlan, weights: np.ndarray, dtype: type) -> Memory:
    """New memory of the step loop."""

    def zeros(*shape: int) -> np.ndarray:
        return np.zeros(shape, dtype)

    n, n_x, apart = plan.n, plan.n_x, plan.n_x > 0 and len(plan.constant.strained) > 0
    daux, terms, jacobian = zeros(n, n_x), allocate_terms(plan, dtype), zeros(len(plan.indices))
    return Memory(
        aux=zeros(n),
        daux=daux,
        flat_daux=daux.reshape(-1),
        carried=zeros(n),
        **{name: zeros(n, filled_up(n_x)) for name in ("dcarried", "pseudo_load", "moved", "rate")},
        span=np.zeros(1),
        kept=np.zeros(1),
        trend=zeros(HIGHEST_ORDER, n),
        fitted=np.zeros(HIGHEST_ORDER),
        fit_sums=np.zeros((HIGHEST_ORDER, LANES)),
        fit_rows=np.zeros((plan.n_q, LANES)),
        fit_columns=np.zeros((HIGHEST_ORDER, plan.n_q)),
        fit_root=np.zeros((HIGHEST_ORDER, HIGHEST_ORDER)),
        learnt=np.zeros(10),
        guess=zeros(n),
        q_predicted=zeros(n),
        v_predicted=zeros(n),
        residual=zeros(n),
        correction=zeros(n),
        jacobian=jacobian,
        rest=zeros(len(plan.indices) if apart else 0),
        mixed=zeros(len(plan.indices)),
        terms=terms,
        whole=terms._replace(**dict.fromkeys(("I_acc", "I_q", "A_q", "A_v"), jacobian)),
        work=allocate_work(plan, dtype),
        solver=linear_solver(lu_plan, weights[: plan.n_q], n_x, dtype),
    )
