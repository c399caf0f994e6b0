"""Richardson: what a sequence of ever finer runs converges to, how fast, and how far off that is.

With runs f_1, f_2, f_3 at h, h/2, h/4 and an error of order p, the observed order and the extrapolated values are

    p = log2 |(f_1 - f_2) / (f_2 - f_3)|,    e_k = f_(k+1) + (f_(k+1) - f_k) / (2^p - 1)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

NEAR = 0.3
"""How far an observed order may be from the known one: the next power of h still counts where this one is seen."""
ORDERS = (0.8, 6.0)
"""Observed orders that can be believed where none is known."""
STALLED = 0.5
"""Observed orders below, of either sign, are no convergence."""


@dataclass(frozen=True)
class Limit:
    """A value, how far off it may be, and the observed order; nan if the runs show none, so that nothing was extrapolated.

    `stalled`: the last halving changed as much as the one before, so that more of them may change it without end.
    """

    value: float
    error: float
    order: float
    stalled: bool = False

    def plus(self, other: Limit, at: float) -> Limit:
        """Both corrections of a value `at` at which both sequences meet; their errors add up."""
        return Limit(self.value + other.value - at, self.error + other.error, self.order, self.stalled)


def limit(runs: list[float], order: int | None) -> Limit:
    """Limit of the last three of runs, each with half the step of the one before.

    If the order is known and observed, the value is e_2 and its error |e_2 - e_1| / (2^(p+1) - 1): what the next power of h leaves.
    If it is only observed, the value is e_2 with that order, and its error as large as the whole correction |e_2 - f_3|. If none is
    observed (the runs do not converge yet, or have converged to round-off), the value is f_3 and its error the largest difference
    between the runs.
    """
    f_1, f_2, f_3 = runs[-3:]
    observed = _observed(f_1 - f_2, f_2 - f_3)
    if order is not None and abs(observed - order) <= NEAR:
        e_1, e_2 = (fine + (fine - coarse) / (2**order - 1) for coarse, fine in ((f_1, f_2), (f_2, f_3)))
        return Limit(e_2, abs(e_2 - e_1) / (2 ** (order + 1) - 1), observed)
    if order is None and ORDERS[0] <= observed <= ORDERS[1]:
        correction = (f_3 - f_2) / (2**observed - 1)
        return Limit(f_3 + correction, abs(correction), observed)
    return Limit(f_3, max(abs(f_3 - f_2), abs(f_2 - f_1)), math.nan, abs(observed) < STALLED)


def _observed(before: float, after: float) -> float:
    return math.log2(before / after) if before * after > 0 else math.nan
