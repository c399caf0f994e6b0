"""Paths of the numbers of vectors, which x, y and z name as well as 0, 1 and 2."""

from __future__ import annotations

from collections.abc import Container, Mapping
from typing import Any, get_args

from toolkit.description.description import Description, Triple

AXES = ("x", "y", "z")


def numbered(path: str, groups: Mapping[str, Mapping[str, Any]]) -> str:
    """The path with the number of the axis: `loads.pull.force.z` is `loads.pull.force.2`; any other path as it is.

    Parameters
    ----------
    groups : of a scene in space; a triple in the plane is no vector
    """
    group, name, field, axis = (*path.split("."), "", "", "", "")[:4]
    item = groups.get(group, {}).get(name)
    if path.count(".") != 3 or axis not in AXES or not isinstance(item, Description):
        return path
    described = type(item).model_fields.get(field)
    if described is None or Triple not in (described.annotation, *get_args(described.annotation)):
        return path
    return f"{group}.{name}.{field}.{AXES.index(axis)}"


def lettered(path: str, known: Container[str]) -> str:
    """The path of a pair's number by its letter, `coefficients.0` is `coefficients.x`, where that is the one among the `known` paths.

    Two numbers are taken for a vector of the plane, also where they are a list that could be longer.
    """
    stem, _, number = path.rpartition(".")
    letter = f"{stem}.{AXES[int(number)]}"
    return letter if path not in known and letter in known else path
