"""All numbers of a scene in the order of its numbering, real or complex: the construction formulas evaluated once.

The compilation evaluates them at the scene's values, and with a complex step in every design variable what that variable may change.
That is exact to round-off, and it happens before time starts to run.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy as np

from toolkit.bodies.body import ConstantNumbers
from toolkit.compilation.dependence import Affected, Item, affected_by
from toolkit.compilation.numbering import Numbering
from toolkit.compilation.remembered import Remembered
from toolkit.curves.curve import Curve
from toolkit.description.design import Design
from toolkit.foundation.errors import InputError
from toolkit.loads.load import Load
from toolkit.loads.spatial.pressure import Pressure, PressureNumbers
from toolkit.markers.component import Component
from toolkit.scene.scene import Scene

T = TypeVar("T")
STEP = 1e-30
"""Complex step: far below round-off, so that nothing but the first derivative is left."""


@dataclass(frozen=True)
class Quantities:
    """Numbers of a scene, each under its number in the order of bodies, markers, joints, loads, curves.

    The values of a scene hold them all, their derivatives by one variable only those that the variable may change.
    """

    start: dict[int, tuple[np.ndarray, np.ndarray]]  # coordinates and velocities of each body
    constant: dict[int, ConstantNumbers]
    floating: dict[int, Any]  # FloatingNumbers or SpatialFloatingNumbers of the bodies that have them
    markers: dict[int, Any]  # MarkerNumbers or SpatialMarkerNumbers
    joints: dict[int, np.ndarray]  # the numbers of the rows, see `joints.rows`
    loads: dict[int, np.ndarray]  # (5,) parameters, in space (7,)
    pressures: dict[int, PressureNumbers]
    gravity: np.ndarray  # (d,)
    curves: dict[int, Curve]


def evaluate_quantities(scene: Scene, numbering: Numbering, affected: Affected | None = None) -> Quantities:
    """All numbers of a scene, or those of some items and markers."""

    def chosen(group: str, items: Mapping[str, T]) -> dict[int, T]:
        return {k: item for k, (name, item) in enumerate(items.items()) if affected is None or (group, name) in affected.items}

    placed: Any = Remembered(scene)
    everybody: Mapping[str, Any] = scene.all_bodies()
    bodies, joints, loads = chosen("bodies", everybody), chosen("joints", scene.joints), chosen("loads", named_loads(scene))
    gravity = scene.gravity
    floating = {b: body.floating(placed) for b, body in bodies.items()}
    return Quantities(
        {b: body.initial_state(placed) for b, body in bodies.items()},
        {b: body.constant(placed, gravity) for b, body in bodies.items()},
        {b: block for b, block in floating.items() if block is not None},
        {
            m: _marker(placed, everybody, grip)
            for m, grip in enumerate(numbering.markers)
            if affected is None or m in affected.markers
        },
        {j: np.array(joint.parameters(placed)) for j, joint in joints.items()},
        {k: _parameters(placed, load, scene.space.load_parameters) for k, load in loads.items()},
        {
            p: pressure.numbers_on(placed, everybody[pressure.body])
            for p, pressure in chosen("loads", pressures_of(scene)).items()
        },
        np.asarray(gravity),
        {c: curve for c, (item, curve) in enumerate(curves_of(scene)) if affected is None or item in affected.items},
    )


def _marker(scene: Scene, everybody: Mapping[str, Any], grip: tuple[str, ...]) -> Any:
    """Numbers of one marker, in space with the axes of its component if it has some."""
    body, point = grip[:2]
    if len(grip) == 2:
        return everybody[body].marker(scene, point, body)
    group, name = _owner(grip)
    return everybody[body].marker(scene, point, body, getattr(scene, group)[name].axes)


def _owner(grip: tuple[str, ...]) -> Item:
    """The component whose axes a marker has."""
    group, _, name = grip[2].partition(".") if len(grip) == 3 else ("", "", "")
    return group, name


def loads_of(scene: Scene) -> list[Load]:
    """Loads that grip markers; gravity does not."""
    return list(named_loads(scene).values())


def named_loads(scene: Scene) -> dict[str, Load]:
    """The same with their names."""
    return {name: load for name, load in scene.loads.items() if isinstance(load, Load)}


def pressures_of(scene: Scene) -> dict[str, Pressure]:
    """Loads on surfaces of flexible bodies, by name."""
    return {name: load for name, load in scene.loads.items() if isinstance(load, Pressure)}


def curves_of(scene: Scene) -> list[tuple[Item, Curve]]:
    """Time curves of joints, then of loads, then of pressures, and whose they are."""
    components: list[tuple[str, Mapping[str, Component]]] = [("joints", scene.joints), ("loads", named_loads(scene))]
    found = [((group, name), component.time_curve) for group, items in components for name, component in items.items()]
    found += [(("loads", name), pressure.curve) for name, pressure in pressures_of(scene).items()]
    return [(item, curve) for item, curve in found if curve is not None]


def _parameters(scene: Scene, component: Component, width: int) -> np.ndarray:
    """A load's parameters, padded with zeros to a width."""
    row = component.parameters(scene)
    if len(row) > width:
        raise InputError(f"a component has {len(row)} parameters, at most {width} are possible: {component!r}.")
    return np.array([*row, *[0.0] * (width - len(row))])


def derivatives(scene: Scene, numbering: Numbering, design: Design, among: Affected | None = None) -> list[Quantities]:
    """Derivative of all numbers, or of those `among` some, by each design variable; curves stay complex, they are differentiated where
    they are evaluated."""
    found = []
    for variable in design:
        affected = affected_by(scene, numbering.markers, list(variable.paths), numbering.users)
        moved = scene.moved(variable, 1j * STEP)
        stepped = evaluate_quantities(moved, numbering, affected if among is None else affected & among)
        parts = {f.name: getattr(stepped, f.name) for f in fields(Quantities)}
        found.append(Quantities(**{name: part if name == "curves" else _imag(part) for name, part in parts.items()}))
    return found


def _imag(value):
    if isinstance(value, dict):
        return {key: _imag(item) for key, item in value.items()}
    if isinstance(value, tuple):
        items = (_imag(item) for item in value)
        return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
    return value if np.asarray(value).dtype.kind == "i" else np.imag(value) / STEP  # places stay what they are
