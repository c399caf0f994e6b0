"""Smooth maxima whose parameter is so small that they lie far above the largest value: max <= KS <= max + ln(n) / rho."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.responses.over_time.extremes import TimeKS
from toolkit.responses.over_time.over_time import over_all_steps
from toolkit.responses.stress.stress import KSStress
from toolkit.system.solution import Solution

LOOSE = 0.05
"""Part of the largest value by which a smooth maximum may exceed it without a word, as of other errors of a response."""


def loose_maxima(solution: Solution) -> Iterator[Caution]:
    """Doubt for every smooth maximum that differs too much from the largest value, as far as all values are kept."""
    if solution.run_times is not None:
        return
    for name, response in solution.system.scene.responses.items():
        if not isinstance(response, KSStress | TimeKS) or (response.needs_motion and not solution.steps):
            continue
        considered = _values(response, solution)
        largest = float(considered.max())
        above = float(np.log(np.sum(np.exp(response.sharpness * (considered - largest))))) / response.sharpness
        if above > LOOSE * abs(largest):
            sharp = np.log(considered.size) / (LOOSE / 5 * abs(largest)) if largest else np.inf
            yield Caution(
                "loose-maximum",
                f"{name} is a smooth maximum of {considered.size} values, {largest + above:.4g}, and lies {above:.3g} above the largest of "
                f"them, {largest:.4g}: its parameter is too small for values of this size, and its gradient that of a mean. "
                + (
                    f"With rho = {sharp:.1g} (in 1/unit of the value) it lies at most 1 % above."
                    if largest
                    else "All of them are zero."
                ),
            )


def _values(response: KSStress | TimeKS, solution: Solution) -> np.ndarray:
    """Values (n,) that the smooth maximum is taken of."""
    if isinstance(response, KSStress):
        return np.real(response.considered(solution)).ravel()
    return np.real(response.considered(over_all_steps(response.source, solution)))
