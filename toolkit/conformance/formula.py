"""The formula of a load on its own: each derivative that it fills against a complex step of what it fills before."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toolkit.conformance.comparison import STEP, compare
from toolkit.conformance.residual import design_paths
from toolkit.foundation.errors import ConformanceError
from toolkit.foundation.kernel import plain
from toolkit.loads.kernels.load_kernel import ARGUMENTS as LOAD_ARGUMENTS
from toolkit.loads.kernels.load_kernel import SPATIAL_ARGUMENTS
from toolkit.loads.load import Load
from toolkit.markers.component import Component
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene

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
