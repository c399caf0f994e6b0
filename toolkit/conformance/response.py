"""A response's partial derivatives against complex steps, in states that are neither small nor consistent.

One complex step along a direction of all numbers shows whether any derivative is wrong; only then each is looked at, to name it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.conformance.comparison import STEP, agree, compare, direction
from toolkit.conformance.residual import design_paths
from toolkit.description.design import DesignVariable
from toolkit.responses.response import STATES, Response
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import System, compile_scene

PARTS = np.array([0.0, 1.0, 1.3])
"""Times, in parts of the one that the response looks at; unequal steps, so that none counts like another."""


def check_partials(response: Response, scene: Scene, seed: int = 0) -> None:
    """d value / d state at every time, and d value / d number for every number of the scene, against complex steps."""
    response.check(scene)
    paths, markers = design_paths(scene), response.grips(scene)
    system = compile_scene(scene, paths, markers)
    states = random_states(system, response.needs_motion, seed)
    times = PARTS * (getattr(response, "time", None) or 0.3)
    times = times[-len(states["q"]) :]
    found = response.partials(solution_of(system, times, states))
    least = max(1e-4 * float(abs(np.real(found.value))), 1e-12)  # derivatives that cancel to zero leave round-off
    as_complex = compile_scene(_complex(scene, paths[0]), None, markers)
    for name in STATES:
        known = getattr(found, name)
        exact = np.zeros(states[name].shape)
        ours = exact if known is None else np.real(known)
        every = direction(exact.size).reshape(exact.shape)
        along = _by_state(response, as_complex, times, states, name, every)
        if agree(np.sum(ours * every), along, max(np.abs(ours).max(initial=0), least)):
            continue
        for place in np.ndindex(*exact.shape):
            unit = np.zeros(exact.shape)
            unit[place] = 1
            exact[place] = _by_state(response, as_complex, times, states, name, unit)
        axes = [[f"t = {time:g}" for time in times], _names(system, name)]
        compare(f"d {response.kind} / d {name}", ours, exact, axes, least)
    ours, every = np.zeros(len(paths)) if found.design is None else np.real(found.design), direction(len(paths))
    along = _by_numbers(response, scene, dict(zip(paths, every.tolist(), strict=True)), times, states)
    if agree(ours @ every, along, max(np.abs(ours).max(initial=0), least)):
        return
    exact = np.array([_by_numbers(response, scene, {path: 1.0}, times, states) for path in paths])
    compare(f"d {response.kind} / d number", ours, exact, [paths], least)


def random_states(system: System, moving: bool, seed: int = 0) -> dict[str, np.ndarray]:
    """q near the start, v, a and multipliers at some times, all random and of order one."""
    rng, n_t = np.random.default_rng(seed), len(PARTS) if moving else 1
    found = {name: rng.normal(size=(n_t, system.n_q)) for name in ("q", "v", "a")}
    found["q"] = system.start()[0][: system.n_q] + 0.3 * found["q"]
    return {**found, "multipliers": rng.normal(size=(n_t, system.n - system.n_q))}


def solution_of(system: System, times: np.ndarray, states: dict[str, np.ndarray]) -> Solution:
    """A solution that nothing has solved, with derivatives that are zero."""
    rest: dict[str, Any] = {f"d{name}": np.zeros((*state.shape, system.n_x)) for name, state in states.items()}
    return Solution(system=system, times=times, **{**rest, **states})


def _complex(scene: Scene, path: str) -> Scene:
    return scene.with_number(path, complex(scene.number(path)))


def _by_state(
    response: Response, system: System, times: np.ndarray, states: dict[str, np.ndarray], name: str, factors: np.ndarray
) -> Any:
    """Derivative of the value along a direction of one state."""
    moved = {**states, name: states[name] + 1j * STEP * factors}
    return np.imag(response.value(solution_of(system, times, moved))) / STEP


def _by_numbers(
    response: Response, scene: Scene, factors: dict[str, float], times: np.ndarray, states: dict[str, np.ndarray]
) -> Any:
    """Derivative of the value along a direction of some numbers."""
    moved = scene.moved(DesignVariable("direction", 1.0, tuple(factors), tuple(factors.values())), 1j * STEP)
    system = compile_scene(moved, None, response.grips(scene))
    return np.imag(response.value(solution_of(system, times, states))) / STEP


def _names(system: System, state: str) -> tuple[str, ...]:
    n_q = system.n_q
    return system.numbering.names[n_q:] if state == "multipliers" else system.numbering.names[:n_q]
