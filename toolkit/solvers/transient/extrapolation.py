"""First guess of a step's accelerations and multipliers: the way they went in the last steps, continued.

With the backward differences d1, d2 of [a; lam] behind the last step the guesses of order 0, 1 and 2 are a_n, a_n + d1, a_n + d1 + d2.
A smooth motion makes each of them better than the one before by a factor of the size of the step, a coarse or sudden one makes it
worse; so the order of the next step is the one that would have been best in the last.
"""

from toolkit.foundation.kernel import inlined
from toolkit.solvers.transient.scheme import by_acceleration

ORDER, EXPECTED, BEND, UNCHECKED, AWAY, QUALITY, UNREFINED, BEST = range(8)
"""Places in `Memory.learnt`: order of the next guess; the correction that it would have needed in the last step, 0 if unknown; what a
correction leaves in parts of its square, for how many steps Newton has not looked, and by how much it has moved since the factors were
made; what the last refinement changed in parts of the correction, 0 if unknown, how many corrections were not refined since,
and the least change so far; see `newton`."""
SMOOTH = 1e-4
"""Part of the scene's size (or rad) by which a guess of higher order may miss: where steps are coarse the equations have several
solutions, and the one next to the last state is meant."""
BETTER = 0.5
"""Part of the miss of one order that the next has to undercut: round-off alone is no trend, its differences grow with the order."""


@inlined
def forget_trend(memory):
    """As at the start of a run, and where the way of the last steps has misled Newton."""
    memory.trend[:] = 0
    memory.learnt[ORDER], memory.learnt[EXPECTED] = 0, 0


@inlined
def guess(plan, ratio, memory, before, acc):
    """First guess of [a; lam] in `acc`, from those of the step `before`; `ratio` of the lengths of both steps."""
    trend, order = memory.trend, memory.learnt[ORDER]
    if ratio != 1:
        memory.learnt[EXPECTED] = 0
        for i in range(plan.n):
            trend[0, i] *= ratio
            trend[1, i] *= ratio * ratio
    for i in range(plan.n):
        acc[i] = before[i]
        if order > 0:
            acc[i] += trend[0, i]
        if order > 1:
            acc[i] += trend[1, i]


@inlined
def learn_trend(plan, scheme, weights, before, acc, memory):
    """Differences behind an accepted step, and the order that would have been best for it."""
    (c_q, _), trend = by_acceleration(scheme), memory.trend
    miss_0, miss_1, miss_2 = 0.0, 0.0, 0.0
    for i in range(plan.n):
        first = acc[i] - before[i]
        second = first - trend[0, i]
        third = second - trend[1, i]
        trend[0, i], trend[1, i] = first, second
        if i < plan.n_q:
            miss_0 = max(miss_0, weights[i] * abs(first.real))
            miss_1 = max(miss_1, weights[i] * abs(second.real))
            miss_2 = max(miss_2, weights[i] * abs(third.real))
    order, miss = 0, c_q * miss_0
    if c_q * miss_1 < min(BETTER * miss, SMOOTH):
        order, miss = 1, c_q * miss_1
    if c_q * miss_2 < min(BETTER * miss, SMOOTH):
        order, miss = 2, c_q * miss_2
    memory.learnt[ORDER], memory.learnt[EXPECTED] = order, miss
