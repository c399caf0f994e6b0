"""Numbers beside pictures: limits of colours, decimals, distances of ticks."""

from __future__ import annotations

import numpy as np

MINUS = "\N{MINUS SIGN}"
"""Minus sign as axes write it."""


def round_up(value: float) -> float:
    """Next larger number with a short decimal form that can be halved; zero stays zero."""
    if value == 0:
        return 0.0
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(power * digit for digit in (1, 1.2, 1.6, 2, 2.4, 3, 4, 5, 6, 8, 10) if power * digit >= value))


def even(value: float, finest: float) -> str:
    """A number with as many decimals as it takes to show `finest`, however large it is itself; in powers of ten if those are many."""
    decimals = max(0, -int(np.floor(np.log10(finest))))
    return f"{round(value, decimals) + 0.0:.{decimals}f}" if decimals < 6 and finest < 1e3 else f"{value:.2e}"


def tick_step(least: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is not less than a length."""
    power = 10.0 ** np.floor(np.log10(least))
    return float(next(power * digit for digit in (1, 2, 5, 10) if power * digit >= least * (1 - 1e-9)))
