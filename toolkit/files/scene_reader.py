"""Scenes in TOML: the same objects as in Python, with errors that name the file, the key and what would be right."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from toolkit.components.curves.catalogue import Curve
from toolkit.description.description import Description, Registered
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.description.validation_messages import messages
from toolkit.foundation.errors import SHORT, InputError, meant
from toolkit.foundation.files.toml_file import naming_lines, parse_toml, read_toml, refuse_other
from toolkit.foundation.value_types import TomlTable, TomlValue
from toolkit.responses.catalogue import Response
from toolkit.responses.response import Instant
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.design_variables import refuse_wrong_variables
from toolkit.scene.kinds import DIMENSIONS, kinds_of
from toolkit.scene.scene import GROUPS, Scene

D = TypeVar("D", bound=Description)
K = TypeVar("K", bound=Registered)


def read_scene(path: str | Path, changes: Mapping[str, TomlValue] | None = None) -> Scene:
    """Scene that a file in TOML describes.

    Parameters
    ----------
    path
        The file, in TOML.
    changes
        Values that replace those of the file, by path or short name: numbers, or texts as they would stand in the file, such as
        {"points.A.x": 73.0, "solver.scheme": "paper"}.

    Returns
    -------
    scene
        The scene, checked; models of its bodies are read when they are needed.

    Raises
    ------
    InputError
        The file is missing, is no TOML, or a key or value is wrong; all wrong keys are reported at once.
    """
    path = Path(path)
    table = read_toml(path, "a scene in TOML")
    short, common, single = table.get("design", {}), dict[str, Any](), set[str]()
    for key, text in (changes or {}).items():
        long = short.get(key) if isinstance(short, dict) else None
        if isinstance(long, dict):
            common[key] = _value(text)
        else:
            single.add(long if isinstance(long, str) else key)
            _change(table, long if isinstance(long, str) else key, text, path)
    refuse_other(table, path, "scene")
    with naming_lines(path, changed={*single, *common}):
        scene = scene_from_table(table, path)
    for name in common:
        if (
            twice := next((each for each in scene.paths_of(name) if each in {scene.path_of(key) for key in single}), None)
        ) is not None:
            raise InputError(f"{path.name}: {name!r} drives {twice}, which is given a value of its own too. Give one of them.")
    return with_numbers(scene, common)[0] if common else scene


def scene_from_table(table: TomlTable, path: Path) -> Scene:
    """Scene from nested tables; `path` is the file they came from.

    Raises
    ------
    InputError
        A key or value is wrong; all wrong ones are reported at once.
    """
    problems: list[str] = []
    dimension = _dimension(table, path)
    groups = {name: _group(table.get(name, {}), name, problems) for name in GROUPS}
    parsed: dict[str, Any] = {name: {} for name in groups}
    for name, text in groups["points"].items():
        parsed["points"][name] = _point(text, dimension, f"points.{name}", problems)
    kinds: dict[str, Mapping[str, type[Registered]]] = {**kinds_of(dimension), "responses": Response.kinds}
    others = kinds_of(5 - dimension)
    for group, known in kinds.items():
        for name, item in groups[group].items():
            parsed[group][name] = _item(item, known, others.get(group, {}), f"{group}.{name}", problems)
    if "solver" in table:
        parsed["solver"] = _validated(RunOptions, table["solver"], "solver", problems)
    rest = {key: value for key, value in table.items() if key not in (*groups, "solver")}
    if problems:
        raise InputError("\n".join(f"{path.name}: {problem}" for problem in problems))
    scene = _validated(Scene, {**rest, **parsed, "directory": path.parent}, "", problems)
    if scene is None:
        raise InputError("\n".join(f"{path.name}: {problem}" for problem in problems))
    try:
        refuse_wrong_variables(scene, scene.design, "design")
    except InputError as error:
        raise InputError(f"{path.name}: {error}") from error
    return scene


def responses_from_table(table: TomlValue, problems: list[str]) -> dict[str, Response]:
    """Responses from a table of names as it stands in a scene file; what is wrong with them is added to the problems."""
    items = _group(table, "responses", problems)
    found = {name: _item(item, Response.kinds, {}, f"responses.{name}", problems) for name, item in items.items()}
    return {name: response for name, response in found.items() if isinstance(response, Response)}


def _dimension(table: TomlTable, path: Path) -> int:
    """Dimension of the scene, 2 or 3, on which everything else depends.

    Raises
    ------
    InputError
        It is neither 2 nor 3.
    """
    given = table.get("dimension", 2)
    if type(given) is not int or given not in DIMENSIONS:
        raise InputError(
            f"{path.name}: dimension = {SHORT.repr(given)} is invalid. Write dimension = 3 for a scene in space, and 2, or nothing, "
            "for one in the plane."
        )
    return given


def _group(value: TomlValue, name: str, problems: list[str]) -> TomlTable:
    if isinstance(value, dict):
        return value
    problems.append(f"{name} must be a table of names, not {SHORT.repr(value)}.")
    return {}


SPACES = {2: "a planar point has two, [x, y]", 3: "a point in space has three, [x, y, z]"}


def _point(value: TomlValue, dimension: int, where: str, problems: list[str]) -> Point | BodyPoint | None:
    if isinstance(value, list):
        if len(value) == dimension:
            return _validated(Point, dict(zip("xyz", value, strict=False)), where, problems)
        other = 5 - dimension
        hint = f" A scene of dimension {other} begins with dimension = {other}." if len(value) == other else ""
        problems.append(f"{where} has {len(value)} coordinates; {SPACES[dimension]}.{hint}")
        return None
    if not isinstance(value, dict) or not value.keys() & BodyPoint.model_fields.keys():
        problems.append(
            f"{where} = {SHORT.repr(value)} is no point; {SPACES[dimension]}, and one on a body a table of body and interface."
        )
        return None
    return _validated(BodyPoint, value, where, problems)


def _item(
    value: TomlValue, kinds: Mapping[str, type[K]], others: Mapping[str, type[Registered]], where: str, problems: list[str]
) -> K | None:
    """Component of the scene from its table; `others` are the kinds that scenes of the other dimension have."""
    if not isinstance(value, dict) or "type" not in value:
        problems.append(f"{where} needs a `type`, one of: {', '.join(sorted(kinds))}.")
        return None
    wanted = value["type"]
    kind = kinds.get(wanted) if isinstance(wanted, str) else None
    if kind is None:
        hint, near = "", meant(wanted, kinds) if isinstance(wanted, str) else ""
        if isinstance(wanted, str) and wanted in others:
            other = others[wanted].dimension
            hint = f" It belongs to scenes with dimension = {other}, this one has dimension = {5 - other}."
        problems.append(f"{where}.type = {SHORT.repr(wanted)} is unknown{near}; available: {', '.join(sorted(kinds))}.{hint}")
        return None
    return _validated(kind, {key: item for key, item in value.items() if key != "type"}, where, problems)


def _validated(kind: type[D], value: object, where: str, problems: list[str]) -> D | None:
    try:
        return kind.model_validate(value)
    except ValidationError as error:
        problems += messages(error, kind, value, where, {**Instant.kinds, **Curve.kinds})
        return None


def _change(table: TomlTable, key: str, text: TomlValue, path: Path) -> None:
    """Set one value by its path; x and y, in space z too, name the entries of a vector."""
    value = _value(text)
    *owners, last = key.split(".")
    owner: Any = table
    dimension, design = table.get("dimension"), table.get("design")
    axes = "xyz"[: dimension if isinstance(dimension, int) and dimension in DIMENSIONS else 2]
    for depth, name in enumerate(owners):
        index = _index(owner, name, axes)
        if index is None and (owners[0] != "solver" or isinstance(owner, list)):
            raise InputError(_leads_nowhere(key, name, owner, axes, path))
        if index is None:
            owner[name] = {}
            index = name
        owner = owner[index]
        if not isinstance(owner, (dict, list)):
            raise InputError(f"{path.name}: {key!r} leads nowhere: {'.'.join(owners[: depth + 1])} is a value, not a table.")
    index = _index(owner, last, axes)
    if index is None and (isinstance(owner, list) or not owners):
        short = design if isinstance(design, dict) and not owners else ()
        raise InputError(_leads_nowhere(key, last, owner, axes, path, short))
    if index is None and len(owners) == 1 and owners[0] in GROUPS and not isinstance(value, dict | list):
        raise InputError(_leads_nowhere(key, last, owner, axes, path))
    owner[last if index is None else index] = value


def _value(text: TomlValue) -> TomlValue:
    """Value that a text stands for in a file."""
    try:
        return parse_toml(f"value = {text}")["value"] if isinstance(text, str) else text
    except ValueError:
        return text


def _index(owner: TomlTable | list[TomlValue], name: str, axes: str) -> str | int | None:
    if isinstance(owner, list):
        axis = axes.find(name) if len(name) == 1 else -1
        index = axis if axis >= 0 else int(name) if name.isdecimal() and len(name) < 10 else len(owner)
        return index if index < len(owner) else None
    return name if name in owner else None


def _leads_nowhere(
    key: str, name: str, owner: TomlTable | list[TomlValue], axes: str, path: Path, short: Iterable[str] = ()
) -> str:
    letters, close = ", ".join(axes), [*short, *owner] if isinstance(owner, dict) else []
    possible = ", ".join(owner) if isinstance(owner, dict) else letters if len(owner) == len(axes) else f"0 to {len(owner) - 1}"
    return f"{path.name}: {SHORT.repr(key)} leads nowhere: there is no {SHORT.repr(name)}{meant(name, close)}; possible here: {possible}."
