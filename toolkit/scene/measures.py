"""Measure of a number of a scene, read from what stands beside its field."""

from __future__ import annotations

from typing import Any

from toolkit.bodies.model_body import ModelBody, refuse_unknown_keys
from toolkit.curves.curve import Curve
from toolkit.description.description import Description, Measure, OverAngle, Quantity
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import Dimension, dimension_of_label

_AXES = "xyz"


def number_measure(scene: Any, path: str) -> Measure:
    """Measure (dimension, power of an angle) of one number that the scene writes, or of a parameter of a reduced model.

    Raises
    ------
    InputError
        Nobody has said what the number of a component is: names class and field.
    """
    group, name, *keys = scene.path_of(path).split(".")
    return measure_in(getattr(scene, group)[name], keys, scene)


def measure_in(item: Description, keys: list[str], scene: Any) -> Measure:
    """Measure of the number that keys lead to from an item."""
    field, *rest = keys
    if isinstance(item, ModelBody) and field not in type(item).model_fields:
        return _parameter(item, field, scene)
    below, said = getattr(item, field, None), item.quantity_of(field)
    if isinstance(below, Curve):
        found = _in_curve(below, rest, said) or _refuse_curve(item, field)
        return _over_angle(found) if isinstance(said, OverAngle) else found
    if isinstance(below, Description):
        return measure_in(below, rest, scene)
    return _at(said, rest) or _refuse(item, field)


def _in_curve(curve: Curve, keys: list[str], values: Quantity | None) -> Measure | None:
    """Measure of a number in a time curve, whose values its owner knows; None if nobody has said it."""
    field, *rest = keys
    below, said = getattr(curve, field), curve.quantity_of(field)
    if isinstance(below, tuple) and rest and isinstance(below[_place(rest)], Curve):
        below, rest = below[_place(rest)], rest[1:]
    if isinstance(below, Curve):
        return _in_curve(below, rest, values if said is not None and said.of_owner else said)
    if said is None:
        return _refuse(curve, field)
    if not said.of_owner:
        return _at(said, rest)
    return None if values is None or values.of_owner else said.measure_of(values.measure(), _place(rest))


def _over_angle(found: Measure) -> Measure:
    """Measure of a number of a curve whose argument is an angle, from its measure in a curve of time."""
    mass, length, time = found.dimension
    return Measure(Dimension(mass, length, 0), found.angle + time)


def _at(said: Quantity | None, keys: list[str]) -> Measure | None:
    """Measure of a number of a field, at the place in a list that the first key gives."""
    return None if said is None or said.of_owner else said.measure(_place(keys))


def _place(keys: list[str]) -> int:
    """Place in a list or a pair that the first key gives."""
    if keys and keys[0] in _AXES:
        return _AXES.index(keys[0])
    return int(keys[0]) if keys and keys[0].isdecimal() else 0


def _refuse(item: Description, field: str) -> Measure:
    raise InputError(
        f"nobody has said what the number {field!r} of a {type(item).__name__} is, so it cannot be given in other units. "
        f'Say it beside the field: `{field}: Annotated[Number, Quantity("length")]`, see toolkit.description.description.'
    )


def _refuse_curve(owner: Description, field: str) -> Measure:
    raise InputError(
        f"nobody has said what the values of the time curve of a {type(owner).__name__} are, so they cannot be given in other "
        f'units. Say it beside the field: `{field}: Annotated[Curve, Quantity("length")]`, see toolkit.description.description.'
    )


def _parameter(body: ModelBody, name: str, scene: Any) -> Measure:
    model = scene.model(body.model)
    refuse_unknown_keys(body, (name,), model, scene)
    return Measure(dimension_of_label(model.nominal_units[name], model.units))
