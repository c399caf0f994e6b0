"""A compiled scene, run once or many times: values, gradients, and the time of each."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass
from typing import Any

from toolkit.foundation.errors import NeedsDirectError
from toolkit.scene.scene import Scene
from toolkit.sensitivity.adjoint.adjoint import adjoint_gradients
from toolkit.sensitivity.analysis import by_name, evaluate_responses, evaluate_with_gradients, prepare, solve
from toolkit.sensitivity.choice import choose
from toolkit.system.solution import Solution
from toolkit.system.system import System


@dataclass(frozen=True)
class Compiled:
    """A scene without and with its design variables, and the method for its gradients: "direct", "adjoint", or "" for none."""

    plain: System
    system: System
    method: str


@dataclass(frozen=True)
class Found:
    """Values, gradients and solution of one run, and its time in s."""

    values: dict[str, Any]
    gradients: dict[str, dict[str, float]]
    solution: Solution
    seconds: float


def compiled(scene: Scene, names: list[str], method: str = "") -> Compiled:
    """A scene ready to run; by default with the method for gradients that is estimated to be the cheaper one."""
    plain = prepare(scene)
    if not names:
        return Compiled(plain, plain, "")
    if method:
        return Compiled(plain, prepare(scene, names), method)
    choice = choose(scene, names, "transient")
    return Compiled(plain, choice.system or prepare(scene, names), choice.method)


def values_once(ready: Compiled) -> Found:
    """One run to the values alone."""
    begun = clock.perf_counter()
    solution = solve(ready.plain, "transient")
    values = evaluate_responses(solution)
    return Found(values, {}, solution, clock.perf_counter() - begun)


def gradients_once(ready: Compiled) -> tuple[Found, str]:
    """One run to values and gradients, and the method that could do it: the adjoint may turn out to need the direct one."""
    if not ready.method:
        return values_once(ready), ""
    if ready.method == "direct":
        return _direct(ready), "direct"
    try:
        return _adjoint(ready), "adjoint"
    except NeedsDirectError:
        return _direct(ready), "direct"


def _direct(ready: Compiled) -> Found:
    begun = clock.perf_counter()
    solution = solve(ready.system, "transient")
    values, gradients = evaluate_with_gradients(solution)
    return Found(values, gradients, solution, clock.perf_counter() - begun)


def _adjoint(ready: Compiled) -> Found:
    begun = clock.perf_counter()
    solution = solve(ready.plain, "transient")
    found, gradient = adjoint_gradients(ready.system, solution)
    seconds = clock.perf_counter() - begun
    values = {name: partials.value for name, partials in found.items()}
    return Found(values, by_name(ready.system.design, found, gradient.T), solution, seconds)
