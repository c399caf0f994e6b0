"""Checks of gradients that a user can call: Taylor test, V-curve of differences, comparison of methods."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from toolkit.scene import Scene
from toolkit.sensitivity.analysis import Kind, direct, values_of
from toolkit.sensitivity.numerical import numerical, typical_size


def taylor_rates(scene: Scene, design: list[str], kind: Kind, steps: Sequence[float] = (2e-3, 1e-3, 5e-4)) -> dict[str, float]:
    """Rate at which |f(x + h d) - f(x) - h g . d| vanishes, d = x (all variables by the same part h): 2 if g is the gradient.

    Returns
    -------
    rates : dict
        Response -> fitted rate.
    """
    variables = scene.design_variables(design)
    base = direct(scene, design, kind)
    sizes = {variable.name: typical_size(scene, variable) for variable in variables}
    remainders: dict[str, list[float]] = {name: [] for name in base.values}
    for h in steps:
        moved = scene
        for variable in variables:
            moved = moved.with_number(variable.path, variable.value + h * sizes[variable.name])
        for name, value in values_of(moved, kind).items():
            slope = sum(base.gradients[name][variable.name] * sizes[variable.name] for variable in variables)
            remainders[name].append(abs(value - base.values[name] - h * slope))
    return {name: float(np.polyfit(np.log(steps), np.log(values), 1)[0]) for name, values in remainders.items()}


def largest_difference(reference: dict[str, dict[str, float]], other: dict[str, dict[str, float]]) -> float:
    """Largest relative difference of two sets of gradients, entry by entry."""
    pairs = [(reference[name][x], other[name][x]) for name in reference for x in reference[name]]
    return max(abs(a - b) / max(abs(a), np.finfo(float).tiny) for a, b in pairs)


def step_study(
    scene: Scene, design: list[str], kind: Kind, steps: Sequence[float] = tuple(10.0 ** np.arange(-1, -11, -1.0))
) -> list[tuple[float, float]]:
    """Central differences against direct differentiation over relative steps: the V of truncation and round-off.

    Returns
    -------
    study : list of pairs
        Relative step and largest relative difference, for every step.
    """
    exact = direct(scene, design, kind).gradients
    return [
        (step, largest_difference(exact, numerical(scene, design, kind, "central-difference", None, step).gradients))
        for step in steps
    ]
