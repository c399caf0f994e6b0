"""Scenes at other numbers, which are checked as if they stood in the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real

from pydantic import ValidationError

from toolkit.description.description import Description
from toolkit.description.validation_messages import messages
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene


def with_numbers(scene: Scene, numbers: Mapping[str, float]) -> tuple[Scene, list[str]]:
    """A copy of a scene at other numbers, and their paths.

    Parameters
    ----------
    scene
        The scene.
    numbers
        Short name or path of each number -> its value.

    Raises
    ------
    InputError
        There is no such number, or its value is invalid: the same words as for a scene file.
    """
    if not isinstance(numbers, Mapping):
        raise InputError(f'numbers are given by name, as in {{"points.A.x": 73.0}}, not as {type(numbers).__name__}.')
    paths: list[str] = []
    alone: dict[str, float] = {}
    for name, value in numbers.items():
        if not isinstance(name, str):
            raise InputError(f"{name!r} is no name of a number. Give short names or paths.")
        if isinstance(value, bool) or not isinstance(value, Real):
            raise InputError(f"{name} = {value!r} is no number. Give a real one.")
        try:
            real = float(value)
        except OverflowError as error:
            raise InputError(f"{name} is larger than any valid number. Fix the exponent.") from error
        mine = scene.paths_of(name)
        if (twice := next((path for path in mine if path in paths), None)) is not None:
            raise InputError(f"{name!r} is the same number as another one that is given, {twice}. Give it once.")
        paths += mine
        if scene.factors_of(name) == (1.0,):
            alone[mine[0]] = real
        else:
            scene = _with_value(scene, name, mine, real)
    scene = scene.with_all(alone)
    _check(scene, paths)
    return scene, paths


def _with_value(scene: Scene, name: str, paths: Sequence[str], value: float) -> Scene:
    """A copy of the scene in which a design variable has a value; numbers that were the factor times the old one stay so."""
    old = scene.value_of(name)
    for path, factor in zip(paths, scene.factors_of(name), strict=True):
        number = scene.number(path)
        scene = scene.with_number(path, factor * value if number == factor * old else number + factor * (value - old))
    return scene


def _check(scene: Scene, paths: Sequence[str]) -> None:
    """Validate all records between the scene and its numbers, each once, for one number after the other the innermost first."""
    checked: set[str] = set()
    for path in paths:
        keys: list[str] = path.split(".")
        found: list[tuple[str, Description]] = []
        owner: object = scene
        for depth, key in enumerate(keys, 1):
            owner = _below(owner, key)
            if isinstance(owner, Description):
                found.append((".".join(keys[:depth]), owner))
        for where, record in reversed(found):
            if where not in checked:
                _check_record(where, record)
        checked |= {where for where, _ in found}


def _check_record(where: str, record: Description) -> None:
    given = {**dict(record), **(record.model_extra or {})}
    try:
        type(record).model_validate(given)
    except ValidationError as error:
        raise InputError("\n".join(messages(error, type(record), given, where, {}))) from error


def _below(owner: object, key: str) -> object:
    """Value that a record, a table or a list holds under a key; None where the path goes on inside of a vector."""
    if isinstance(owner, Description):
        return getattr(owner, key, None)
    if isinstance(owner, Mapping):
        return owner.get(key)
    return owner[int(key)] if isinstance(owner, tuple | list) and key.isdigit() and int(key) < len(owner) else None
