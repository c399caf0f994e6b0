"""A compiled scene, run once or many times: values, gradients, and the time of each."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass
from typing import Any

from toolkit.foundation.errors import NeedsDirectError
from toolkit.scene.scene import Scene
from toolkit.sensitivity.adjoint.adjoint import adjoint_gradients
from toolkit.sensitivity.choice import choose
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.evaluation import by_name, evaluate_responses, evaluate_with_gradients
from toolkit.sensitivity.preparation import solve
from toolkit.system.solution import Solution


@dataclass(frozen=True)
class Ready:
    """A compiled scene, and the method for its gradients: "direct", "adjoint", or "" for none."""

    compiled: Compiled
    method: str


@dataclass(frozen=True)
class Found:
    """Values, gradients and solution of one run, and its time in s."""

    values: dict[str, Any]
    gradients: dict[str, dict[str, float]]
    solution: Solution
    seconds: float


def ready_to_run(scene: Scene, names: list[str], method: str = "") -> Ready:
    """A scene ready to run; by default with the method for gradients that is estimated to be the cheaper one."""
    compiled = Compiled(scene, tuple(names))
    return Ready(compiled, (method or choose(compiled, "transient").method) if names else "")


def values_once(ready: Ready) -> Found:
    """One run to the values alone."""
    begun = clock.perf_counter()
    solution = solve(ready.compiled.primal, "transient")
    values = evaluate_responses(solution)
    return Found(values, {}, solution, clock.perf_counter() - begun)


def gradients_once(ready: Ready) -> tuple[Found, str]:
    """One run to values and gradients, and the method that could do it: the adjoint may turn out to need the direct one."""
    if not ready.method:
        return values_once(ready), ""
    if ready.method == "direct":
        return _direct(ready), "direct"
    try:
        return _adjoint(ready), "adjoint"
    except NeedsDirectError:
        return _direct(ready), "direct"


def _direct(ready: Ready) -> Found:
    begun = clock.perf_counter()
    solution = solve(ready.compiled.full, "transient")
    values, gradients = evaluate_with_gradients(solution)
    return Found(values, gradients, solution, clock.perf_counter() - begun)


def _adjoint(ready: Ready) -> Found:
    begun = clock.perf_counter()
    solution = solve(ready.compiled.primal, "transient")
    found, gradient = adjoint_gradients(ready.compiled.full, solution)
    seconds = clock.perf_counter() - begun
    values = {name: partials.value for name, partials in found.items()}
    return Found(values, by_name(ready.compiled.full.design, found, gradient.T), solution, seconds)
