"""Roots of functions of a parameter that runs nearly as the arc length does.

They are bracketed on the real line, then polished where a complex step is taken.
"""

from __future__ import annotations

from collections.abc import Callable

from scipy.optimize import brentq

from preprocessing.curve.arc_length_spline import Number


def root(f: Callable[[float], float], low: float, high: float, length: float) -> float:
    """Real root of f between two parameters at which it has different signs, on a curve of a given length."""
    return float(brentq(f, low, high, xtol=1e-14 * length))


def polished(f_and_slope: Callable[[Number], tuple[Number, Number]], u: float) -> complex:
    """The complex root whose real part is known: each step of Newton's iteration doubles the right digits, 4 steps are many.

    Parameters
    ----------
    f_and_slope : parameter -> value of an analytic function and of its derivative
    """
    place = complex(u)
    for _ in range(4):
        value, slope = f_and_slope(place)
        place = complex(place - value / slope)
    return place
