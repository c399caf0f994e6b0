"""The design variables of a scene, checked: every path leads to a number with a derivative, and no number is in two of them."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import TYPE_CHECKING

from toolkit.components.bodies.model_body import ModelBody, refuse_unknown_keys
from toolkit.components.curves.curve import Curve
from toolkit.description.description import Description, Measure, OverAngle, Quantity
from toolkit.description.design import AXES, BodyPoint, Design, DesignVariable
from toolkit.foundation.errors import InputError, listed, meant
from toolkit.foundation.units import Dimension, dimension_of_label

if TYPE_CHECKING:
    from toolkit.scene.scene import Scene

_AXES = "xyz"


def number_measure(scene: Scene, path: str) -> Measure:
    """Measure (dimension, power of an angle) of one number that the scene writes, or of a parameter of a reduced model.

    Raises
    ------
    InputError
        Nobody has said what the number of a component is: names class and field.
    """
    group, name, *keys = scene.path_of(path).split(".")
    return measure_in(getattr(scene, group)[name], keys, scene)


def measure_in(item: Description, keys: list[str], scene: Scene) -> Measure:
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


def _parameter(body: ModelBody, name: str, scene: Scene) -> Measure:
    model = scene.model(body.model)
    refuse_unknown_keys(body, (name,), model, scene.bodies)
    return Measure(dimension_of_label(model.nominal_units[name], model.units))


NOT_DESIGN = {
    "solver": "step, stabilisation (Baumgarte) and the other options of the solver change how exactly the motion is found, not the "
    "motion. Choose numbers of points, bodies, joints or loads.",
    "responses": "numbers of a response change what is asked about the motion, not the motion. Choose numbers of points, bodies, "
    "joints or loads.",
}
"""Tables of a scene whose numbers have no derivative, and why."""


def variables_of(scene: Scene, names: Collection[str]) -> Design:
    """Design variables of a scene by short name or path; errors as `Scene.design_variables`."""
    variables: list[DesignVariable] = []
    available, users = dict.fromkeys(scene.available_paths() if names else ()), dict[str, str]()
    for name in names:
        paths = scene.paths_of(name)
        for path in paths:
            _check(scene, path, name, available)
            if path in users:
                raise InputError(_twins(users[path], name, path, len(paths) + len(scene.paths_of(users[path])) > 2))
        users |= dict.fromkeys(paths, name)
        _check_units(scene, name, paths)
        variables.append(DesignVariable(name, scene.value_of(name), paths, scene.factors_of(name)))
    return Design(tuple(variables))


def refuse_wrong_variables(scene: Scene, names: Collection[str], table: str) -> None:
    """Refuse variables that lead nowhere, and two that drive the same number, by the table of the file that names them.

    Raises
    ------
    InputError
        Names the table, and the variable if it is wrong by itself.
    """
    try:
        variables_of(scene, names)
    except InputError as error:
        for name in names:
            try:
                variables_of(scene, [name])
            except InputError as own:
                raise InputError(f"{table}.{name}: {own}") from own
        raise InputError(f"{table}: {error}") from error


def _check(scene: Scene, path: str, name: str, available: Iterable[str]) -> None:
    """Refuse a path that leads nowhere, or to a number without derivative."""
    if path.split(".")[0] in NOT_DESIGN:
        raise InputError(f"{path!r} cannot be a design variable: {NOT_DESIGN[path.split('.')[0]]}")
    if path in available:
        return
    if path.endswith(".arc_length") and path.split(".")[1] in scene.points:
        raise InputError(
            f"{path!r} has no derivative: the point sits at a node of the mesh, where the discretised curve has a kink. "
            "State it by an arc length off the nodes in the skin file, and run preprocessing again."
        )
    table, _, point = path.rpartition(".")[0].partition(".")
    if table == "points" and isinstance(carried := scene.points.get(point), BodyPoint):
        raise InputError(_on_body(path, f"{table}.{point}.arc_length", carried, available))
    which = f"unknown design variable {name!r}"
    if path != name:
        which = f"the path {path!r} of design variable {name!r} leads nowhere"
    raise InputError(
        f"{which}{_meant(path, [*scene.design, *available])}; short names of the scene: {', '.join(scene.design) or 'none'}; "
        f"paths: {listed(list(available))}."
    )


def _meant(path: str, names: Collection[str]) -> str:
    """Suggestion for a wrong path.

    Of a planar velocity's `.x` it is its number `.0`, though `.2`, the rotation, reads as much like it.
    """
    stem, _, axis = path.rpartition(".")
    numbered = f"{stem}.{AXES.index(axis)}" if axis in AXES[:2] else path
    return meant(path, [numbered] if numbered in names else names)


def _on_body(path: str, moving: str, point: BodyPoint, available: Iterable[str]) -> str:
    """Sentence on a path to coordinates of an interface point, which has none of its own, and on what moves the point."""
    which = f"{path!r} leads nowhere: the point lies where {point.interface!r} of body {point.body!r} does"
    if moving in available:
        return f"{which}. Take {moving!r}, which moves it along the body."
    return (
        f"{which}. Along a skin {moving!r} moves it, if the skin file states its arc length off the nodes, as ffrf new wing does: change "
        "that file, and run preprocessing again."
    )


def _twins(one: str, other: str, path: str, several: bool) -> str:
    if one == other or not several:
        return f"design variables {one!r} and {other!r} are the same number, {path}. Name it once."
    return f"design variables {one!r} and {other!r} both drive {path}. Leave it to one of them."


def _check_units(scene: Scene, name: str, paths: tuple[str, ...]) -> None:
    """Refuse a variable that drives a number twice, or numbers that measure different things: its factors are pure numbers."""
    if len(paths) == 1:
        return
    if len(set(paths)) < len(paths):
        twice = next(path for path in paths if paths.count(path) > 1)
        raise InputError(f"design variable {name!r} names {twice} twice. Name it once, with the factor that it shall have.")
    first = number_measure(scene, paths[0])
    for path in paths:
        if number_measure(scene, path) != first:
            raise InputError(
                f"design variable {name!r} drives {paths[0]} and {path}, which measure different things: factors are pure numbers. Let one "
                "variable drive numbers of one unit."
            )
