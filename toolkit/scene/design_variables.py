"""The design variables of a scene, checked: every path leads to a number with a derivative, and no number is in two of them."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

from toolkit.description.design import AXES, BodyPoint, Design, DesignVariable
from toolkit.foundation.errors import InputError, listed, meant
from toolkit.scene.measures import number_measure

NOT_DESIGN = {
    "solver": "step, stabilisation (Baumgarte) and the other options of the solver change how exactly the motion is found, not the "
    "motion. Choose numbers of points, bodies, joints or loads.",
    "responses": "numbers of a response change what is asked about the motion, not the motion. Choose numbers of points, bodies, "
    "joints or loads.",
}
"""Tables of a scene whose numbers have no derivative, and why."""


def variables_of(scene: Any, names: Collection[str]) -> Design:
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


def refuse_wrong_variables(scene: Any, names: Collection[str], table: str) -> None:
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


def _check(scene: Any, path: str, name: str, available: Iterable[str]) -> None:
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
    if table == "points" and isinstance(scene.points.get(point), BodyPoint):
        raise InputError(_on_body(path, f"{table}.{point}.arc_length", scene.points[point], available))
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


def _check_units(scene: Any, name: str, paths: tuple[str, ...]) -> None:
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
