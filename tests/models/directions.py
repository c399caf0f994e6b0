"""A complex step along one direction of all numbers of a scene: a single run of plain Python judges every derivative at once.

With factors f_k of the numbers x_k,  sum_k f_k dr/dx_k = Im r(x + i h f) / h.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from toolkit.description.design import DesignVariable
from toolkit.scene.scene import Scene
from toolkit.sensitivity.numerical import derivative
from toolkit.sensitivity.preparation import Kind
from toolkit.system.solution import Solution


def direction(paths: Iterable[str], seed: int = 0) -> dict[str, float]:
    """A factor for each path, between 1/2 and 1 and of either sign, so that no two derivatives cancel by chance."""
    draw, names = np.random.default_rng(seed), list(paths)
    factors = draw.uniform(0.5, 1.0, len(names)) * draw.choice([-1.0, 1.0], len(names))
    return dict(zip(names, factors.tolist(), strict=True))


def felt_direction(gradients: Mapping[str, Mapping[str, float]], smallest: float, seed: int = 0) -> dict[str, float]:
    """A factor for each number, with which it moves the response that it matters most to by about that one's largest derivative.

    What differs in one number alone then differs by as much relative to that number's own derivative. A number without an effect, below
    the `smallest` part of the largest derivative, is moved a hundred times as far as the one that matters most.
    """
    largest = {name: max(map(abs, slopes.values())) for name, slopes in gradients.items()}
    paths = list(next(iter(gradients.values())))
    share = {path: max(abs(slopes[path]) / largest[name] for name, slopes in gradients.items()) for path in paths}
    return {path: factor / (share[path] if share[path] > smallest else 1e-2) for path, factor in direction(paths, seed).items()}


def derivative_along(
    scene: Scene, factors: Mapping[str, float], kind: Kind, known: Solution | None = None, difference: float | None = None
) -> dict[str, float]:
    """Response -> derivative along the direction, by one complex step, or by a central `difference` over that part of it.

    `known` is that of `derivative`.
    """
    moved = DesignVariable("direction", 1.0, tuple(factors), tuple(factors.values()))
    method = "complex-step" if difference is None else "central-difference"
    return {name: float(value) for name, value in derivative(scene, moved, kind, method, {}, difference, known).items()}


def along(slopes: Mapping[str, float], factors: Mapping[str, float]) -> float:
    """The same from the derivatives by the single numbers."""
    return sum(factor * slopes[path] for path, factor in factors.items())
