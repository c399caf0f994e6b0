"""Lame's constants of plane bodies, per unit of Young's modulus."""

from __future__ import annotations

from typing import Any


def lame_factors(poisson_ratio: Any, state: str) -> tuple[Any, Any]:
    """lambda / E and mu / E; real, or complex for a complex step in nu.

        mu / E = 1 / (2 (1 + nu)),   lambda / E = nu / ((1 + nu) (1 - 2 nu)) in plane strain, nu / (1 - nu^2) in plane stress

    The second form of lambda makes the stress across the plane vanish.
    """
    shear = 1 / (2 * (1 + poisson_ratio))
    if state == "plane-strain":
        return poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio)), shear
    return poisson_ratio / (1 - poisson_ratio**2), shear
