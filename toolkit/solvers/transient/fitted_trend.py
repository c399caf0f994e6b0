"""Multiples of the last differences that would have guessed the last steps best: for motions with vibrations that steps barely resolve.

With the backward differences d1, d2, ... behind a step the change of [a; lam] in the next one is guessed as c1 d1 + c2 d2 + ... . A motion
of a few frequencies has constants c with which this is exact, however large they are in a step; a polynomial has c = 1. The c of the
next step are those of the least squares

    minimise  sum over steps n of  FADING^-n |change_n - sum_k c_k d_k,n|^2,   each coordinate in parts of the model size.

The polynomials of `extrapolation` take less time; so this is done as long as they miss by what costs a further correction.
"""

import numpy as np

from toolkit.foundation.compiled.rows import LANES, add_to_each
from toolkit.foundation.kernel import inner

HIGHEST = 6
"""Differences that guesses are made of. In a chain of 30 rods polynomials of order 2 miss by 7e-9, of 4 by 9e-11, of 6 by 5e-12, after
which one correction leaves nothing; a beam that vibrates by 0.7 rad in a step is missed by 5e-6 by every polynomial, and by 5e-6, 1e-7
and 5e-8 where 3, 4 and 6 differences are fitted."""
FADING = 0.5
"""Weight of a step's misses, in parts of that of the step after it."""
RIDGE = 1e-13
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
        rows[i, HIGHEST] = rest = size * change[i].real
        for k in range(HIGHEST):
            each = size * trend[k, i].real
            rows[i, k] = memory.fit_columns[k, i] = each
            rest -= fitted[k] * each
        miss = max(miss, abs(rest))
    for k in range(HIGHEST):
        for j in range(LANES):
            sums[k, j] *= FADING
    flat = rows.reshape(-1)
    for k in range(0, HIGHEST, 3):
        add_to_each((sums[k], sums[k + 1], sums[k + 2]), memory.fit_columns[k : k + 3], n_q, flat, 0, LANES)
    solve_fit(sums, memory.fit_root, fitted)
    return miss


@inner
def solve_fit(sums, root, fitted):
    """Multiples c from their normal equations, S c = r with [S, r] in `sums`, by Cholesky's factors of D S D + RIDGE, D^-2 = diag S."""
    for k in range(HIGHEST):
        for j in range(k + 1):
            both = np.sqrt(sums[k, k]) * np.sqrt(sums[j, j])
            entry = sums[k, j] / both if both > 0 else 0.0
            for m in range(j):
                entry -= root[k, m] * root[j, m]
            if j < k:
                root[k, j] = entry / root[j, j]
            else:
                root[k, k] = np.sqrt(max(entry, 0.0) + RIDGE)
    for k in range(HIGHEST):
        size = np.sqrt(sums[k, k])
        entry = sums[k, HIGHEST] / size if size > 0 else 0.0
        for m in range(k):
            entry -= root[k, m] * fitted[m]
        fitted[k] = entry / root[k, k]
    for k in range(HIGHEST - 1, -1, -1):
        for m in range(k + 1, HIGHEST):
            fitted[k] -= root[m, k] * fitted[m]
        fitted[k] /= root[k, k]
    for k in range(HIGHEST):
        size = np.sqrt(sums[k, k])
        fitted[k] = fitted[k] / size if size > 0 else 0.0


@inner
def beside(n_q, scale, weights, order, memory):
    """Distance of the next guess by the multiples from that of a polynomial of some order."""
    largest = 0.0
    for i in range(n_q):
        apart = 0.0
        for k in range(HIGHEST):
            apart += (memory.fitted[k] - (1.0 if k < order else 0.0)) * memory.trend[k, i].real
        largest = max(largest, scale * weights[i] * abs(apart))
    return largest


@inner
def forget_fit(memory):
    """Forget the fit of the last steps, as if no step had been seen."""
    memory.fitted[:] = 0
    memory.fit_sums[:] = 0
