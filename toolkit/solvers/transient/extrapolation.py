"""First guess of a step's accelerations and multipliers: the way they went in the last steps, continued.

With the backward differences d1, d2, ... of [a; lam] behind the last step the guesses of order 0, 1, 2, ... are a_n, a_n + d1,
a_n + d1 + d2, ... A smooth motion makes each of them better than the one before by a factor of the size of the step, a coarse or
sudden one makes it worse; so the order of the next step is the one that would have been best in the last, among that of the last
and its neighbours. Where even that costs a further correction, other multiples of the differences are fitted, see `fitted_trend`.
"""

from toolkit.foundation.kernel import inlined
from toolkit.solvers.transient.fitted_trend import HIGHEST, beside, fit_trend, forget_fit
from toolkit.solvers.transient.scheme import by_acceleration

ORDER, EXPECTED, BEND, UNCHECKED, AWAY, QUALITY, UNREFINED, BEST, FITTING, FITTED = range(10)
"""Places in `Memory.learnt`: order of the next guess; the correction that it would have needed in the last step, 0 if unknown; what a
correction leaves in parts of its square, for how many steps Newton has not looked, and by how much it has moved since the factors were
made; what the last refinement changed in parts of the correction, 0 if unknown, how many corrections were not refined since,
and the least change so far; see `newton`. For how many steps multiples of differences will still be fitted, or minus the number of steps
that would have needed it; and whether the next guess is made of those."""
NEGLIGIBLE = 1e-15
"""Part of the model size (or rad) that no step feels: some roundings of it, which is what last corrections of flexible bodies consist
of."""
WANTED, PATIENCE = 10, 20
"""Steps that need multiples before they are fitted, as a short run does not get back what that costs; and steps for which they are fitted
after the last that needed it."""
SMOOTH = 1e-4
"""Part of the model size (or rad) by which a guess of higher order may miss: where steps are coarse the equations have several
solutions, and the one next to the last state is meant. Nor is a fitted one this far from that of the best order."""
BETTER = 0.5
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
        for k in range(HIGHEST):
            for i in range(plan.n):
                trend[k, i] *= power
            power *= ratio
    for i in range(plan.n):
        acc[i] = before[i]
    fitted = memory.learnt[FITTED] > 0
    for k in range(HIGHEST if fitted else order):
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
    for k in range(HIGHEST + 1):
        if lowest <= k <= lowest + 2:
            miss = 0.0
            for i in range(plan.n_q):
                miss = max(miss, weights[i] * abs(change[i].real))
            miss *= c_q
            if k == 0 or miss < min(BETTER * best, SMOOTH) or (k == lowest and miss < SMOOTH):
                order, best = k, miss
        if k < HIGHEST:
            for i in range(plan.n):
                behind = trend[k, i]
                trend[k, i] = change[i]
                change[i] -= behind
    learnt[ORDER], learnt[EXPECTED], learnt[FITTED] = order, best, 0
    if 0 < best < SMOOTH and learnt[BEND] * best * best > NEGLIGIBLE:
        if not fitting and learnt[FITTING] > -WANTED:
            learnt[FITTING] -= 1
        else:
            if not fitting:
                forget_fit(memory)
            learnt[FITTING] = PATIENCE
    elif fitting:
        learnt[FITTING] -= 1
    if fitting and fit_missed < min(BETTER * best, SMOOTH) and beside(plan.n_q, c_q, weights, order, memory) < SMOOTH:
        learnt[EXPECTED], learnt[FITTED] = fit_missed, 1
