"""All numbers of a scene in the order of its numbering, real or complex: the construction formulas evaluated once.

The compilation evaluates them at the scene's values, and with a complex step in every design variable. That is exact to round-off,
and it happens before time starts to run.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from toolkit.bodies.body import ConstantNumbers, FloatingNumbers, MarkerNumbers
from toolkit.compilation.numbering import Numbering
from toolkit.component import Component
from toolkit.errors import InputError
from toolkit.joints.joint_kernel import ARGUMENTS as JOINT_ARGUMENTS
from toolkit.loads.load import Load
from toolkit.loads.load_kernel import ARGUMENTS as LOAD_ARGUMENTS
from toolkit.profile import Curve
from toolkit.scene import Scene

STEP = 1e-30
"""Complex step: far below round-off, so that nothing but the first derivative is left."""


@dataclass(frozen=True)
class Quantities:
    """Numbers of a scene; lists are in the order of bodies, markers, joints, loads."""

    q0: np.ndarray
    v0: np.ndarray
    constant: list[ConstantNumbers]
    floating: list[FloatingNumbers]
    markers: list[MarkerNumbers]
    joints: np.ndarray  # (n_j, 6) parameters, padded with zeros
    loads: np.ndarray  # (n_l, 5)
    gravity: np.ndarray  # (2,)
    curves: list[Curve]


def evaluate_quantities(scene: Scene, numbering: Numbering) -> Quantities:
    """All numbers of a scene."""
    bodies = scene.all_bodies()
    starts = [body.initial_state(scene) for body in bodies.values()]
    floating = [body.floating(scene) for body in bodies.values()]
    return Quantities(
        np.concatenate([q for q, _ in starts]),
        np.concatenate([v for _, v in starts]),
        [body.constant(scene, scene.gravity) for body in bodies.values()],
        [block for block in floating if block is not None],
        [bodies[body].marker(scene, point, body) for body, point in numbering.markers],
        _parameters(scene, list(scene.joints.values()), JOINT_ARGUMENTS - 6),
        _parameters(scene, loads_of(scene), LOAD_ARGUMENTS - 7),
        np.asarray(scene.gravity),
        [component.time_curve for component in curved_components(scene) if component.time_curve is not None],
    )


def loads_of(scene: Scene) -> list[Load]:
    """Loads that grip markers; gravity does not."""
    return [load for load in scene.loads.values() if isinstance(load, Load)]


def curved_components(scene: Scene) -> list[Component]:
    """Joints, then loads, that follow a time curve."""
    components: list[Component] = [*scene.joints.values(), *loads_of(scene)]
    return [component for component in components if component.time_curve is not None]


def _parameters(scene: Scene, components: list, width: int) -> np.ndarray:
    rows = [component.parameters(scene) for component in components]
    table = np.zeros((len(rows), width), np.result_type(float, *(type(value) for row in rows for value in row)))
    for k, row in enumerate(rows):
        if len(row) > width:
            raise InputError(f"a component has {len(row)} parameters, at most {width} are possible: {components[k]!r}.")
        table[k, : len(row)] = row
    return table


def derivative(scene: Scene, numbering: Numbering, path: str) -> Quantities:
    """Derivative of all numbers by the number at one path; curves stay complex, they are differentiated where they are evaluated."""
    stepped = evaluate_quantities(scene.with_number(path, scene.number(path) + 1j * STEP), numbering)
    return Quantities(
        **{
            f.name: getattr(stepped, f.name) if f.name == "curves" else _imag(getattr(stepped, f.name))
            for f in fields(Quantities)
        }
    )


def _imag(value):
    if isinstance(value, list):
        return [_imag(item) for item in value]
    if isinstance(value, tuple):
        return type(value)(*(_imag(item) for item in value))
    return np.imag(value) / STEP
