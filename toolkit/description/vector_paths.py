"""Paths of the numbers of vectors, which x, y and z name as well as 0, 1 and 2."""

from __future__ import annotations

from collections.abc import Container, Mapping
from typing import Any, get_args, get_origin

from toolkit.description.description import Description, Triple

AXES = ("x", "y", "z")


def numbered(path: str, groups: Mapping[str, Mapping[str, Any]]) -> str:
    """Path with the number of the axis: `loads.pull.force.z` is `loads.pull.force.2`; any other path as it is.

    So is `bodies.beam.deflection.tip.z`, of one vector among several that have names.

    Parameters
    ----------
    groups : of a scene in space; a triple in the plane is no vector
    """
    keys = path.split(".")
    group, name, field, axis = (*(*keys, "", "", "")[:3], keys[-1])
    item = groups.get(group, {}).get(name)
    if axis not in AXES or not isinstance(item, Description):
        return path
    described = type(item).model_fields.get(field)
    kind = None if described is None else described.annotation
    depth = 5 if get_origin(kind) is dict else 4
    if len(keys) != depth or Triple not in (kind, *get_args(kind)):
        return path
    return ".".join([*keys[:-1], str(AXES.index(axis))])


def lettered(path: str, known: Container[str]) -> str:
    """Path of a pair's number by its letter, `coefficients.0` as `coefficients.x`, where that is the one among the `known` paths.

    Two numbers are taken for a vector of the plane, also where they are a list that could be longer.
    """
    stem, _, number = path.rpartition(".")
    letter = f"{stem}.{AXES[int(number)]}"
    return letter if path not in known and letter in known else path
