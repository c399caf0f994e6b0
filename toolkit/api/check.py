"""Checks for users: whether one's own joint, load or scene is right in all its derivatives.

A response's partial derivatives against complex steps, in states that are neither small nor consistent.

One complex step along a direction of all numbers shows whether any derivative is wrong; only then each is looked at, to name it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from toolkit.api.comparison import (
    STEP,
    agree,
    check_design_derivatives,
    check_state_derivatives,
    compare,
    design_paths,
    direction,
)
from toolkit.components.curves.curve import Curve
from toolkit.components.joints.joint import Joint, check_rows
from toolkit.components.joints.kernels.profile import profile_law
from toolkit.components.joints.rows import Row
from toolkit.components.loads.kernels.load_kernel import ARGUMENTS as LOAD_ARGUMENTS
from toolkit.components.loads.kernels.load_kernel import SPATIAL_ARGUMENTS
from toolkit.components.loads.load import Load
from toolkit.components.markers.component import Component
from toolkit.description.description import Description
from toolkit.description.design import DesignVariable
from toolkit.foundation.errors import ConformanceError
from toolkit.foundation.kernel import plain
from toolkit.responses.response import STATES, Response
from toolkit.scene.resolution import loaded, resolve
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import System, compile_scene

VECTORS = ("position", "axis 1", "axis 2", "axis 3")
"""Vectors of the pose of a marker in space."""
POSES = {
    2: [f"{what} of {body}" for body in ("a", "b") for what in ("x", "y", "angle")],
    3: [f"{axis} of {vector} of {body}" for body in ("a", "b") for vector in VECTORS for axis in "xyz"],
}
"""Dimension -> numbers of the poses of both markers."""
FORCES = {
    2: [f"{what} on {body}" for body in ("a", "b") for what in ("force in x", "force in y", "torque")],
    3: [f"force in {axis} on {vector} of {body}" for body in ("a", "b") for vector in VECTORS for axis in "xyz"],
}
"""Dimension -> what a load fills, conjugate to the poses."""
ARGUMENTS = {2: LOAD_ARGUMENTS, 3: SPATIAL_ARGUMENTS}
"""Dimension -> arguments of a load; the last one is the value of its curve."""


def check_load_formula(load: Load, scene: Scene, rng: np.random.Generator) -> None:
    """force_z and force_w of force, at random poses and rates; in space of vectors that are no rotations' axes."""
    poses, size = POSES[load.dimension], ARGUMENTS[load.dimension]
    n, curve = len(poses), size - 1
    z, w, used = arguments(load, scene, size, rng)
    z[curve], w, used = rng.normal(), w[: n + 1], np.append(used, curve)
    w[n] = rng.normal() if load.state is not None else 0

    def fill(at: np.ndarray, rates: np.ndarray) -> list[np.ndarray]:
        dtype = np.result_type(at, rates)
        filled = [np.zeros(shape, dtype) for shape in ((n + 1,), (n + 1, size), (n + 1, n + 1))]
        plain(load.law())(at.astype(dtype), rates.astype(dtype), *filled)
        return filled

    force, force_z, force_w = fill(z, w)
    if not load.feels_axes:
        _check_blindness(load, force, force_z, force_w)
    if load.state is None:
        _check_statelessness(load, force_w)
    owner, names = f"{load.kind!r}: ", argument_names(used, size, load.dimension)
    forces = [*FORCES[load.dimension], "rate of the state"]
    compare(f"{owner}force_z", force_z[:, used], stepped(lambda at: fill(at, w)[0], z, used), [forces, names])
    rates = [*(f"rate of {name}" for name in poses), "state"]
    compare(f"{owner}force_w", force_w, stepped(lambda rate: fill(z, rate)[0], w, np.arange(n + 1)), [forces, rates])


def _check_statelessness(load: Load, force_w: np.ndarray) -> None:
    """A load without a state of its own does not use one."""
    if np.any(force_w[:-1, -1]):
        raise ConformanceError(
            f"{load.kind!r}: its formula uses the last place of `w`, that of a state of its own, but it has none: nobody would "
            'integrate it. Say what the state is an integral of: let `state` return "length" or "angle".'
        )


def _check_blindness(load: Load, force: np.ndarray, force_z: np.ndarray, force_w: np.ndarray) -> None:
    """A load that says that it does not feel axes has neither forces on them nor derivatives by them."""
    axes = [k for k, name in enumerate(POSES[load.dimension]) if "axis" in name]
    if (
        np.any(force[axes])
        or np.any(force_z[:, axes])
        or np.any(force_z[axes])
        or np.any(force_w[:, axes])
        or np.any(force_w[axes])
    ):
        raise ConformanceError(
            f"{load.kind!r}: its formula uses axes of the markers, but `feels_axes` is False, so that nobody computes them. Leave "
            "`feels_axes` out."
        )


def arguments(load: Load, scene: Scene, size: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """z = (random poses, the load's parameters), rates w that are zero for parameters, numbers of the arguments that can change.

    A parameter that no number of the scene moves, a switch, has no derivative that anyone could use.
    """
    n = len(POSES[load.dimension])
    parameters = np.array(load.parameters(loaded(scene)), float)
    z, w = np.zeros((2, size))
    z[:n], w[:n] = rng.normal(size=(2, n))
    z[n : n + len(parameters)] = parameters
    moved = moved_numbers("loads", load, scene)
    return z, w, np.append(np.arange(n), n + np.flatnonzero(moved))


def moved_numbers(group: str, component: Component, scene: Scene) -> np.ndarray:
    """Which parameters of a component some number of the scene moves, if it is the only one of its group."""
    moved = np.zeros(len(component.parameters(loaded(scene))), bool)
    alone = loaded(scene).model_copy(update={"joints": {}, "loads": {}} | {group: {"component": component}})
    for path in design_paths(alone):
        other = alone.with_number(path, alone.number(path) + 1j * STEP)
        moved |= np.imag(getattr(other, group)["component"].parameters(other)) != 0
    return moved


def argument_names(used: np.ndarray, size: int, dimension: int) -> list[str]:
    """Names of the arguments in use; the last of `size` is the curve of a load."""
    poses = POSES[dimension]
    return [poses[k] if k < len(poses) else "curve" if k == size - 1 else f"parameter z[{k}]" for k in used]


def stepped(function: Callable[[np.ndarray], np.ndarray], z: np.ndarray, used: np.ndarray) -> np.ndarray:
    """Complex-step derivatives of a function by the arguments in use, on the last axis."""
    return np.stack([function(z + 1j * STEP * np.eye(len(z))[k]).imag / STEP for k in used], axis=-1)


PARTS = np.array([0.0, 1.0, 1.3])
"""Times, in parts of the one that the response looks at; unequal steps, so that none counts like another."""


def check_partials(response: Response, scene: Scene, seed: int = 0) -> None:
    """d value / d state at every time, and d value / d number for every number of the scene, against complex steps."""
    scene = loaded(scene)
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
) -> float:
    """Derivative of the value along a direction of one state."""
    moved = {**states, name: states[name] + 1j * STEP * factors}
    return np.imag(response.value(solution_of(system, times, moved))) / STEP


def _by_numbers(
    response: Response, scene: Scene, factors: dict[str, float], times: np.ndarray, states: dict[str, np.ndarray]
) -> float:
    """Derivative of the value along a direction of some numbers."""
    moved = scene.moved(DesignVariable("direction", 1.0, tuple(factors), tuple(factors.values())), 1j * STEP)
    system = compile_scene(moved, None, response.grips(resolve(scene)))
    return np.imag(response.value(solution_of(system, times, states))) / STEP


def _names(system: System, state: str) -> tuple[str, ...]:
    n_q = system.n_q
    return system.numbering.names[n_q:] if state == "multipliers" else system.numbering.names[:n_q]


DIFFERENCE_STEPS = 0.02 / 2.0 ** np.arange(5)
"""Steps of the differences that are extrapolated, as parts of the number, or of the times."""
DIFFERENCE_TOLERANCE = 1e-6
"""Part of the largest derivative by a number by which a complex step and extrapolated differences may differ: the round-off of
differences is 1e-11, and that of the last extrapolation still smaller; a formula that drops an imaginary part is wrong by all of it."""
DISTANCE_FROM_CORNERS = 0.05
"""Distance of the times from corners, as a part of the interval: differences look a fraction of it to both sides."""


def check_curve(curve: Curve, interval: tuple[float, float] = (0.0, 1.0), seed: int = 0) -> None:
    """Check every derivative of a time curve at random times: f' and f'' by a complex step in time, those by its numbers by differences.

    Parameters
    ----------
    curve
        The curve.
    interval
        Times to look at; those near its corners are left out.
    seed
        Another one gives other times.

    Raises
    ------
    ConformanceError
        f' or f'' differs from a complex step of f or f' by more than 1e-10 of the largest, or a complex step in a number from
        differences; names the derivative, the time and both values. Or the curve has other than three rates, or they are not finite.
    """
    times = _times(curve, interval, np.random.default_rng(seed))
    at = [f"t = {time:.4g}" for time in times]
    rates = _finite(curve, times)
    moved = np.imag(curve.evaluate(times + 1j * STEP)) / STEP
    for k, name in enumerate(("f'", "f''")):
        compare(f"{name} of the time curve {curve.kind!r}", rates[:, k + 1], moved[:, k], [at], _least(rates[:, k], interval))
    for path, value in curve.numbers():
        exact = np.imag(curve.with_number(path, value + 1j * STEP).evaluate(times)) / STEP
        _compare_with_differences(curve, path, float(np.real(value)), exact, times, interval)


def _times(curve: Curve, interval: tuple[float, float], rng: np.random.Generator) -> np.ndarray:
    """Random times of the interval that are clear of corners."""
    low, high = interval
    corners = np.real(np.array(curve.corners(), complex))
    times = np.sort(rng.uniform(low, high, 60))
    near = np.abs(times[:, None] - corners).min(axis=1, initial=np.inf) < DISTANCE_FROM_CORNERS * (high - low)
    if near.all():
        raise ConformanceError(
            f"the time curve {curve.kind!r} has a corner near every time from {low:g} to {high:g}: give another `interval`."
        )
    return times[~near]


def _finite(curve: Curve, times: np.ndarray) -> np.ndarray:
    """Rates f, f', f'' of a curve at the times, (n_t, 3), refused if they are not finite."""
    if (count := len(curve.rates(times))) != 3:
        raise ConformanceError(f"`rates` of the time curve {curve.kind!r} gives {count} arrays; three are needed: f, f', f''.")
    found = curve.evaluate(times)
    if np.iscomplexobj(found) or not np.isfinite(found).all():
        raise ConformanceError(f"the time curve {curve.kind!r} is not finite and real at all times of the interval.")
    return found


def _least(values: np.ndarray, interval: tuple[float, float]) -> float:
    """Least scale of derivatives: the slope of a curve that changes by its largest value within the interval."""
    return float(np.abs(values).max() / (interval[1] - interval[0]))


def _compare_with_differences(
    curve: Curve, path: str, value: float, exact: np.ndarray, times: np.ndarray, interval: tuple[float, float]
) -> None:
    size = abs(value) or 1.0
    by_time = DISTANCE_FROM_CORNERS * (interval[1] - interval[0])
    step = min(size, by_time) if size > by_time else size
    differences = extrapolated(lambda h: np.real(curve.with_number(path, value + h).evaluate(times)), step * DIFFERENCE_STEPS)
    for k, name in enumerate(("f", "f'", "f''")):
        largest = max(float(np.abs(differences[:, k]).max()), float(np.abs(curve.evaluate(times)[:, k]).max()) / size)
        wrong = np.abs(exact[:, k] - differences[:, k])
        if wrong.max() > DIFFERENCE_TOLERANCE * largest:
            n = int(np.argmax(wrong))
            raise ConformanceError(
                f"the derivative of {name} of the time curve {curve.kind!r} by {path} is wrong at t = {times[n]:.4g}: a complex step "
                f"gives {exact[n, k]:.10g}, differences {differences[n, k]:.10g}. The formulas of `rates` must hold for complex "
                "numbers: no abs, no real part, no float()."
            )


def extrapolated(function: Callable[[float], np.ndarray], steps: Sequence[float] | np.ndarray) -> np.ndarray:
    """Central differences with halved steps, extrapolated by Richardson to a step of zero."""
    table = [(function(h) - function(-h)) / (2 * h) for h in map(float, steps)]
    for order in range(1, len(table)):
        table = [fine + (fine - coarse) / (4**order - 1) for coarse, fine in pairwise(table)]
    return np.asarray(table[0])


def check_laws(joint: Joint, scene: Scene, rng: np.random.Generator) -> None:
    """g_h of g, g_hh of g_h, and g_hww of w^T g_hh w, at random values and rates of all forms that are no constants.

    A constant that no number of the scene moves, a switch, has no derivative that anyone could use.
    """
    moved, before = moved_numbers("joints", joint, scene), 0
    for row in joint.constraint(loaded(scene)):
        used = []
        for f, form in enumerate(row.forms):
            last = before + len(form.numbers)
            if form.linear or form.pairs or moved[before:last].any():
                used.append(f)
            before = last
        if row.law not in (None, profile_law):  # numbers of a profile are no forms: the equations of the whole scene judge them
            _check_law(joint, row, np.array(used, int), rng)


def _check_law(joint: Joint, row: Row, used: np.ndarray, rng: np.random.Generator) -> None:
    n = len(row.forms)
    h, w = rng.normal(size=(2, n))
    for f, form in enumerate(row.forms):
        if not (form.linear or form.pairs):
            h[f], w[f] = form.constant, 0.0

    def fill(at: np.ndarray) -> list[np.ndarray]:
        filled = [np.zeros(shape, at.dtype) for shape in ((1,), (n,), (n, n), (n,))]
        plain(row.law)(at, w.astype(at.dtype), *filled)
        return filled

    _, g_h, g_hh, g_hww = fill(h)
    owner, names = f"row {row.name!r} of {joint.kind!r}: ", [f"h[{f}]" for f in used]
    compare(f"{owner}g_h", g_h[None, used], stepped(lambda at: fill(at)[0], h, used), [[row.name], names])
    second, exact = g_hh[np.ix_(used, used)], stepped(lambda at: fill(at)[1][used], h, used)
    compare(f"{owner}g_hh", second, exact, [names, names])
    exact = stepped(lambda at: (w @ fill(at)[2] @ w)[None], h, used)
    compare(f"{owner}g_hww", g_hww[None, used], exact, [[row.name], names])


def check_joint(joint: Joint, scene: Scene, seed: int = 0) -> None:
    """Check every derivative of a joint at random poses and rates: those of its open formulas, then what the equations make of them.

    Rows that are forms have no derivatives of their own.

    Parameters
    ----------
    joint : the joint; its bodies and points are those of the scene
    scene : any scene with those bodies and points; its own joints and loads are left out
    seed : another one gives other poses and rates

    Raises
    ------
    ConformanceError
        A derivative differs from a complex step by more than 1e-10 of the largest; names the derivative, the entry and both values.
    ValueError
        The joint names a body or a point that the scene does not have; or a row of it is invalid.
    """
    alone = _alone(scene, joints={"joint": joint})
    check_rows(joint, loaded(alone))
    check_laws(joint, alone, np.random.default_rng(seed))
    check_scene(alone, seed)


def check_load(load: Load, scene: Scene, seed: int = 0) -> None:
    """Check every derivative of a load; arguments and errors as `check_joint`."""
    alone = _alone(scene, loads={"load": load})
    check_load_formula(load, alone, np.random.default_rng(seed))
    check_scene(alone, seed)


def check_response(response: Response, scene: Scene, seed: int = 0) -> None:
    """Check a response's partial derivatives by the states at every time, and by every number that can be a design variable.

    Parameters
    ----------
    response : the response; its bodies and points are those of the scene
    scene : any scene with those bodies, points, joints and loads
    seed : another one gives other states

    Raises
    ------
    ConformanceError
        A derivative differs from a complex step by more than 1e-10 of the largest; names the derivative, the entry and both values.
    InputError
        The response asks for what the scene does not have.
    """
    alone = Scene(**{**dict(scene), "responses": {"response": response}, "design": {}})
    check_partials(response, alone, seed)


def check_scene(scene: Scene, seed: int = 0) -> None:
    """Check the derivatives of a whole scene's equations by its state, and by every number that can be a design variable.

    The compiled equations run against complex steps of the same equations as plain Python, so a formula with a branch that only
    one of both takes is found too. Errors as `check_joint`.
    """
    check_state_derivatives(scene, seed)
    check_design_derivatives(scene, seed)


def _alone(scene: Scene, **component: Mapping[str, Description]) -> Scene:
    """Scene with its bodies and points and one component alone, which is refused if it names others."""
    return Scene(**{**dict(scene), "joints": {}, "loads": {}, "responses": {}, "design": {}, **component})
