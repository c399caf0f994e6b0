"""Values of a scene's responses after a run, and their gradients."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from toolkit.description.design import Design
from toolkit.scene.scene import Scene
from toolkit.sensitivity.preparation import Kind, moving, prepare, responses_of, solve
from toolkit.system.solution import Solution


def evaluate_responses(solution: Solution) -> dict[str, Any]:
    """Values of all responses of the scene."""
    return {name: response.value(solution) for name, response in responses_of(solution.system.scene, moving(solution)).items()}


def evaluate_with_gradients(solution: Solution) -> tuple[dict[str, Any], dict[str, dict[str, float]]]:
    """Values of all responses of the scene, and their gradients by the derivatives that the solution holds."""
    found = {
        name: response.evaluate(solution) for name, response in responses_of(solution.system.scene, moving(solution)).items()
    }
    gradients = by_name(solution.system.design, found, (slopes for _, slopes in found.values()))
    return {name: value for name, (value, _) in found.items()}, gradients


def values_of(scene: Scene, kind: Kind) -> dict[str, Any]:
    """Values of all responses after one run, without derivatives."""
    return evaluate_responses(solve(prepare(scene), kind))


def by_name(design: Design, responses: Iterable[str], slopes: Iterable[np.ndarray]) -> dict[str, dict[str, float]]:
    """Derivatives (n_x,) of each response as response -> variable -> derivative."""
    pairs = zip(responses, slopes, strict=True)
    return {name: dict(zip(design.names, map(float, each), strict=True)) for name, each in pairs}
