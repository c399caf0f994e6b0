"""Lame's constants, per unit of Young's modulus."""

from __future__ import annotations

from typing import Any


def lame_factors(poisson_ratio: Any, state: str) -> tuple[Any, Any]:
    """lambda / E and mu / E; real, or complex for a complex step in nu.

        mu / E = 1 / (2 (1 + nu)),   lambda / E = nu / ((1 + nu) (1 - 2 nu)), or nu / (1 - nu^2) in plane stress

    The first form of lambda is that of space and of plane strain; the second makes the stress across the plane vanish.
    """
    shear = 1 / (2 * (1 + poisson_ratio))
    if state == "plane-stress":
        return poisson_ratio / (1 - poisson_ratio**2), shear
    return poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio)), shear
