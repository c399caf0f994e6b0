"""A complex step along one direction of all numbers of a scene: a single run of plain Python judges every derivative at once.

With factors f_k of the numbers x_k,  sum_k f_k dr/dx_k = Im r(x + i h f) / h.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from toolkit.analyses.sensitivity.direct import derivative
from toolkit.analyses.sensitivity.preparation import Kind, frozen, prepare
from toolkit.analyses.transient import simulate
from toolkit.description.design import DesignVariable
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution


def direction(paths: Iterable[str], seed: int = 0) -> dict[str, float]:
    """A factor for each path, between 1/2 and 1 and of either sign, so that no two derivatives cancel by chance."""
    draw, names = np.random.default_rng(seed), list(paths)
    factors = draw.uniform(0.5, 1.0, len(names)) * draw.choice([-1.0, 1.0], len(names))
    return dict(zip(names, factors.tolist(), strict=True))


def felt_direction(
    gradients: Mapping[str, Mapping[str, float]], without: float, counts_as: float = 1e-2, seed: int = 0
) -> dict[str, float]:
    """A factor for each number, with which it moves the response that it matters most to by about that one's largest derivative.

    What differs in one number alone then differs by as much relative to that number's own derivative. One below the part `without` of the
    largest derivative has no effect, and is moved as if it were the part `counts_as`: otherwise its round-off would be what is compared.
    """
    largest = {name: max(map(abs, slopes.values())) for name, slopes in gradients.items()}
    paths = list(next(iter(gradients.values())))
    share = {path: max(abs(slopes[path]) / largest[name] for name, slopes in gradients.items()) for path in paths}
    parts = {path: part if part > without else counts_as for path, part in share.items()}
    return {path: factor / parts[path] for path, factor in direction(paths, seed).items()}


def derivative_along(
    scene: Scene, factors: Mapping[str, float], kind: Kind, known: Solution | None = None, difference: float | None = None
) -> dict[str, float]:
    """Response -> derivative along the direction of some variables, by one complex step, or by a central `difference` over that part of it.

    A complex step is taken beside a `known` equilibrium, of a motion that in which it starts, or along a known motion.
    """
    moved = combined(scene, factors)
    method = "complex-step" if difference is None else "central-difference"
    solutions = (None, known) if known and known.steps else (known, None)
    return {name: float(value) for name, value in derivative(scene, moved, kind, method, {}, difference, *solutions).items()}


def combined(scene: Scene, factors: Mapping[str, float]) -> DesignVariable:
    """One variable that moves variables of a scene, short names or paths, by their factors."""
    parts = [
        (path, own * factor)
        for name, factor in factors.items()
        for path, own in zip(scene.paths_of(name), scene.factors_of(name), strict=True)
    ]
    return DesignVariable("direction", 1.0, tuple(path for path, _ in parts), tuple(factor for _, factor in parts))


def along(slopes: Mapping[str, float], factors: Mapping[str, float]) -> float:
    """The same from the derivatives by the single numbers."""
    return sum(factor * slopes[path] for path, factor in factors.items())


def check_states(scene: Scene, run: Solution, tolerance: float) -> None:
    """All derivatives of all states of a run against complex steps of all its variables through the same accepted steps.

    Once the variables move the multipliers alike, once the places, so that what is wrong by one of them shows beside the others.
    """
    names = [variable.name for variable in run.system.design]
    for by in (run.dmultipliers, run.dq):
        sizes = np.abs(by).max(axis=(0, 1))
        factors = np.array(list(direction(names).values())) / np.maximum(sizes, 1e-3 * sizes.max())
        step = combined(scene, dict(zip(names, factors.tolist(), strict=True)))
        stepped = simulate(prepare(frozen(scene, run).moved(step, 1e-30j)), along=run)
        for name in ("q", "v", "a", "multipliers"):
            exact, ours = getattr(stepped, name).imag / 1e-30, getattr(run, f"d{name}") @ factors
            np.testing.assert_allclose(ours, exact, rtol=0, atol=tolerance * np.abs(exact).max(), err_msg=name)
