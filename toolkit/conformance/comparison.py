"""Two arrays that should be one: the worst entry is named, with both values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from toolkit.foundation.errors import ConformanceError

STEP = 1e-30
"""Complex step: far below round-off, so that nothing but the first derivative is left."""

TOLERANCE = 1e-10
"""Relative to the largest entry: only round-off separates an exact derivative from a complex step."""


def direction(count: int) -> np.ndarray:
    """A factor for each of some numbers, between 1/2 and 1 and of either sign, so that no two differences cancel by chance."""
    rng = np.random.default_rng(count)
    return rng.uniform(0.5, 1.0, count) * rng.choice([-1.0, 1.0], count)


def agree(ours: Any, exact: Any, size: float) -> bool:
    """Whether derivatives along a direction differ by no more than `TOLERANCE` times a size; what is not finite does not."""
    return bool(np.all(np.abs(ours - exact) <= TOLERANCE * max(size, float(np.abs(exact).max(initial=0)))))


def compare(what: str, ours: np.ndarray, exact: np.ndarray, names: Sequence[Sequence[str]], least: float = 1e-300) -> None:
    """Raise an error if the arrays differ by more than `TOLERANCE` times the largest entry (or `least`).

    Parameters
    ----------
    what : the derivative, for the message
    names : for every axis, what its entries are

    Raises
    ------
    ConformanceError
        Names the entry with the largest difference, both values and the difference relative to the largest entry.
    """
    size = max(float(np.abs(exact).max(initial=0)), least)
    difference = np.where(np.isfinite(ours), np.abs(ours - exact), np.inf)
    if difference.size == 0 or difference.max() <= TOLERANCE * size:
        return
    worst = tuple(int(k) for k in np.unravel_index(int(np.argmax(difference)), difference.shape))
    place = ", ".join(axis[k] for axis, k in zip(names, worst, strict=True))
    share = f"{difference[worst] / size:.2g} of the largest entry" if size > least else "where all should be zero"
    raise ConformanceError(
        f"{what} is wrong at ({place}): it is {ours[worst]:.10g}, a complex step gives {exact[worst]:.10g}; "
        f"the difference is {difference[worst]:.2g}, {share}."
    )
