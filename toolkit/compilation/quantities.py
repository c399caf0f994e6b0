"""All numbers of a scene in the order of its numbering, real or complex: the construction formulas evaluated once.

The compilation evaluates them at the scene's values, and with a complex step in every design variable what that variable may change.
That is exact to round-off, and it happens before time starts to run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import partial
from operator import is_
from typing import Any, NamedTuple, TypeVar

import numpy as np

from toolkit.bodies.body import ConstantNumbers
from toolkit.compilation.dependence import Affected, Item
from toolkit.compilation.numbering import Numbering
from toolkit.compilation.remembered import Remembered
from toolkit.curves.curve import Curve
from toolkit.description.design import Design
from toolkit.foundation.errors import InputError
from toolkit.loads.gravity import UniformGravity
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


class Part(NamedTuple):
    """One item's share of a group: what the scene writes about it, and its numbers as they follow from a scene."""

    written: tuple[Any, ...]
    make: Callable[[Any], Any]


class Seen(NamedTuple):
    """How some numbers of a scene came about."""

    placed: Remembered
    parts: dict[str, dict[int, Part]]
    asked: dict[tuple[str, int], frozenset[Any]]  # of the scene, for the numbers of an item


class Change(NamedTuple):
    """Derivatives of a scene's numbers by one variable: those that may be other than zero, and of each group the items that are not."""

    rates: Quantities
    still: dict[str, set[int]]


def evaluate_quantities(scene: Scene, numbering: Numbering, affected: Affected | None = None) -> Quantities:
    """All numbers of a scene, or those of some items and markers."""
    return seen_quantities(scene, numbering, affected)[0]


def seen_quantities(
    scene: Scene, numbering: Numbering, affected: Affected | None = None, remembered: Remembered | None = None
) -> tuple[Quantities, Seen]:
    """The same, and how they came about."""
    placed, parts = remembered or Remembered(scene), _parts(scene, numbering, affected)
    asked: dict[tuple[str, int], frozenset[Any]] = {}
    groups: dict[str, dict[int, Any]] = {group: {} for group in parts}
    for group, owners in parts.items():
        for owner, part in owners.items():
            groups[group][owner], asked[group, owner] = placed.watched(part.make)
    return _quantities(groups, scene), Seen(placed, parts, asked)


def _quantities(groups: dict[str, dict[int, Any]], scene: Scene) -> Quantities:
    """Those bodies alone have invariants of a moving frame that have such a frame."""
    floating = {b: block for b, block in groups["floating"].items() if block is not None}
    return Quantities(**{**groups, "floating": floating}, gravity=np.asarray(scene.gravity))


def _parts(scene: Scene, numbering: Numbering, affected: Affected | None) -> dict[str, dict[int, Part]]:
    """What has numbers, by group and number."""

    def chosen(group: str, items: Mapping[str, T]) -> dict[int, T]:
        return {k: item for k, (name, item) in enumerate(items.items()) if affected is None or (group, name) in affected.items}

    everybody: Mapping[str, Any] = scene.all_bodies()
    bodies, joints, loads = chosen("bodies", everybody), chosen("joints", scene.joints), chosen("loads", named_loads(scene))
    gravity, width = scene.gravity, scene.space.load_parameters
    heavy = tuple(each for each in scene.loads.values() if isinstance(each, UniformGravity))
    pressures = chosen("loads", pressures_of(scene))
    return {
        "start": {b: Part((body,), body.initial_state) for b, body in bodies.items()},
        "constant": {b: Part((body, *heavy), partial(_constant, body, gravity)) for b, body in bodies.items()},
        "floating": {b: Part((body,), body.floating) for b, body in bodies.items()},
        "markers": {
            m: _marker(scene, everybody, grip)
            for m, grip in enumerate(numbering.markers)
            if affected is None or m in affected.markers
        },
        "joints": {j: Part((joint,), partial(_rows, joint)) for j, joint in joints.items()},
        "loads": {k: Part((load,), partial(_parameters, load, width)) for k, load in loads.items()},
        "pressures": {
            p: Part((load, everybody[load.body]), partial(_pressure, load, everybody[load.body])) for p, load in pressures.items()
        },
        "curves": {
            c: Part((curve,), partial(_itself, curve))
            for c, (item, curve) in enumerate(curves_of(scene))
            if affected is None or item in affected.items
        },
    }


def _constant(body: Any, gravity: np.ndarray, placed: Any) -> ConstantNumbers:
    found: ConstantNumbers = body.constant(placed, gravity)
    return found


def _rows(joint: Any, placed: Any) -> np.ndarray:
    return np.array(joint.parameters(placed))


def _pressure(pressure: Pressure, body: Any, placed: Any) -> PressureNumbers:
    return pressure.numbers_on(placed, body)


def _itself(curve: Curve, _: Any) -> Curve:
    return curve


def _marker(scene: Scene, everybody: Mapping[str, Any], grip: tuple[str, ...]) -> Part:
    """One marker, in space with the axes of its component if it has some."""
    body, point = grip[:2]
    if len(grip) == 2:
        return Part((everybody[body],), partial(_placed_marker, everybody[body], point, body, ()))
    group, name = _owner(grip)
    component = getattr(scene, group)[name]
    return Part((everybody[body], component), partial(_placed_marker, everybody[body], point, body, (component.axes,)))


def _placed_marker(body: Any, point: str, name: str, axes: tuple[Any, ...], placed: Any) -> Any:
    return body.marker(placed, point, name, *axes)


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


def _parameters(component: Component, width: int, placed: Any) -> np.ndarray:
    """A load's parameters, padded with zeros to a width."""
    row = component.parameters(placed)
    if len(row) > width:
        raise InputError(f"a component has {len(row)} parameters, at most {width} are possible: {component!r}.")
    return np.array([*row, *[0.0] * (width - len(row))])


def derivatives(scene: Scene, numbering: Numbering, design: Design, seen: Seen, among: Affected | None = None) -> list[Change]:
    """Derivative of all numbers, or of those `among` some, by each design variable; curves stay complex, they are differentiated where
    they are evaluated.

    Only what is written otherwise, or is told something else by the scene, can have a derivative: the other formulas are left out.
    """
    found = []
    for variable in design:
        affected = numbering.affected_by(scene, variable.paths)
        moved = scene.moved(variable, 1j * STEP)
        parts = _parts(moved, numbering, affected if among is None else affected & among)
        placed = Remembered(moved, seen.placed)
        stirred = _stirred(seen, placed)
        groups = {group: {k: part for k, part in owners.items() if stirred(group, k, part)} for group, owners in parts.items()}
        rates = _quantities({name: {k: part.make(placed) for k, part in each.items()} for name, each in groups.items()}, moved)
        named = {f.name: getattr(rates, f.name) for f in fields(Quantities)}
        rates = Quantities(**{name: part if name == "curves" else _imag(part) for name, part in named.items()})
        found.append(Change(rates, {group: parts[group].keys() - groups[group].keys() for group in parts}))
    return found


def _stirred(seen: Seen, moved: Remembered) -> Callable[[str, int, Part], bool]:
    """Whether the numbers of an item can be others in a scene of which other numbers are `moved`."""
    same: dict[Any, bool] = {}

    def unchanged(question: Any) -> bool:
        if question not in same:
            same[question] = seen.placed.answers_as(moved, question)
        return same[question]

    def stirred(group: str, owner: int, part: Part) -> bool:
        before = seen.parts[group][owner].written
        written = len(before) == len(part.written) and all(map(is_, before, part.written))
        return not (written and all(map(unchanged, seen.asked[group, owner])))

    return stirred


def _imag(value):
    if isinstance(value, dict):
        return {key: _imag(item) for key, item in value.items()}
    if isinstance(value, tuple):
        items = (_imag(item) for item in value)
        return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
    return value if np.asarray(value).dtype.kind == "i" else np.imag(value) / STEP  # places stay what they are
