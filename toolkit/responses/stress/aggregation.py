"""Kreisselmeier-Steinhauser: a smooth upper bound of a maximum."""

from __future__ import annotations

import numpy as np


def kreisselmeier_steinhauser(values: np.ndarray, aggregation: float) -> tuple[complex, np.ndarray]:
    """Smooth maximum and its derivative by every value, safe from overflow (paper, eqs. 47 and 51).

        KS = m + ln(sum_k exp(rho (g_k - m))) / rho,    m = max g,    dKS/dg_k = exp(rho (g_k - KS))

    with rho = `aggregation`, in 1/unit of the values. max g <= KS <= max g + ln(n) / rho.

    Returns
    -------
    value : float or complex
    weights : array
        Of the values' shape; they sum to one.
    """
    largest = values.flat[np.argmax(values.real)].real
    parts = np.exp(aggregation * (values - largest))
    total = parts.sum()
    return largest + np.log(total) / aggregation, parts / total


def gap_bound(count: int, aggregation: float) -> float:
    """Most that KS can exceed the true maximum of `count` values: ln(n) / rho."""
    return float(np.log(count) / aggregation)
