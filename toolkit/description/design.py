"""Design variables: short names for the paths of numbers in a scene, in the order of the columns of every derivative."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Self, get_args, get_origin

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from toolkit.description.description import Description, Number, Quantity, Triple
from toolkit.foundation.value_types import Record


class Point(Description):
    """A point given by its coordinates.

    Attributes
    ----------
    x
        Coordinate in the undeformed global configuration, in units of length.
    y
        Likewise.
    z
        Likewise, of a spatial scene alone.
    """

    x: Annotated[Number, Quantity("length")]
    y: Annotated[Number, Quantity("length")]
    z: Annotated[Number | None, Quantity("length")] = None

    def position(self) -> np.ndarray:
        """Coordinates of the point, shape (2,) or (3,)."""
        return np.array([self.x, self.y] if self.z is None else [self.x, self.y, self.z])


class BodyPoint(Description):
    """An interface point of a flexible body; `arc_length` moves it along the body, within the element it was made for.

    Attributes
    ----------
    body
        Name of the flexible body.
    interface
        Name of the interface point in the body's reduced model; "(frame)" is the origin of the body's frame, which does not deform.
    arc_length
        Place along the body, in units of length from its start; by default where preprocessing put the point.
    """

    body: str
    interface: str
    arc_length: Annotated[Number | None, Quantity("length")] = None


AXES = ("x", "y", "z")


def numbered(path: str, groups: Mapping[str, Mapping[str, object]]) -> str:
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


class CommonVariable(Description):
    """One design variable that drives several numbers: where it grows by d, each grows by d times its factor.

    Its value is that of the first number over its factor. So where all numbers are equal and all factors one, it is what they have in
    common; where they are not, they keep their differences, and a value moves all as it moves the first.

    Attributes
    ----------
    of
        Paths of numbers of one unit, each in no other variable.
    factors
        Of each number, not zero; all are one by default.
    """

    of: tuple[str, ...] = Field(min_length=1)
    factors: Annotated[tuple[Number, ...] | None, Quantity("none")] = None

    @model_validator(mode="after")
    def _fit(self) -> Self:
        check_shares(self.of, self.factors)
        return self

    @property
    def shares(self) -> tuple[float, ...]:
        """Factors of the numbers, also where they are not written."""
        return (1.0,) * len(self.of) if self.factors is None else self.factors


def check_shares(of: tuple[str, ...] | None, factors: tuple[float, ...] | None) -> None:
    """Refuse numbers of a variable that are named twice, or whose factors are too few, too many, zero, or of no numbers."""
    if of is None:
        if factors is not None:
            raise ValueError("factors belong to the numbers of `of`; name these, or leave the factors out")
        return
    if len(set(of)) < len(of):
        twice = next(path for path in of if of.count(path) > 1)
        raise ValueError(f"`of` names {twice} twice; name each number once, with the factor that it shall have")
    if factors is not None and len(factors) != len(of):
        raise ValueError(f"{len(of)} paths but {len(factors)} factors; give as many of each, or no factors if all are one")
    if 0 in (factors or ()):
        raise ValueError(f"the factor of {of[(factors or ()).index(0)]} is zero, so that nothing drives it; leave it out of `of`")


def _entry(value: object) -> str | CommonVariable:
    """Path as it is, or the table of a variable of several numbers."""
    if isinstance(value, str | CommonVariable):
        return value
    if isinstance(value, Mapping):
        return CommonVariable.model_validate(value)
    raise ValueError(
        'a design variable is the path of a number, "points.A.x", or a table { of = ["points.A.x", "points.B.x"] } of several'
    )


DesignEntry = Annotated[str | CommonVariable, BeforeValidator(_entry)]
"""Entry beside a name in the table [design]."""


@dataclass(frozen=True)
class DesignVariable:
    """A short name, the paths of the numbers that it drives, for example `points.A.x`, and by which factors.

    Its value is that of the first number over its factor.
    """

    name: str
    value: float
    paths: tuple[str, ...]
    factors: tuple[float, ...] = (1.0,)

    @property
    def path(self) -> str:
        """Path of the first number, whose unit and kind all numbers of the variable have."""
        return self.paths[0]

    def record(self) -> Record:
        """Path and value of the variable; for several numbers all paths and factors too."""
        several: Record = (
            {"of": list(self.paths), "factors": list(self.factors)} if len(self.paths) > 1 or self.factors != (1.0,) else {}
        )
        return {"path": self.path, "value": self.value, **several}


def label(record: Mapping[str, Any]) -> str:
    """Text with all paths of a variable, from its `record`, and with factors that are not one."""
    paths, factors = record.get("of", [record["path"]]), record.get("factors", [1.0])
    return ", ".join(path if factor == 1 else f"{factor:g} {path}" for path, factor in zip(paths, factors, strict=True))


@dataclass(frozen=True)
class Design:
    """The design variables of a scene; their order is the order of the last axis of all derivatives."""

    variables: tuple[DesignVariable, ...]

    def __len__(self) -> int:
        return len(self.variables)

    def __iter__(self) -> Iterator[DesignVariable]:
        return iter(self.variables)

    @property
    def names(self) -> tuple[str, ...]:
        """Short names of the variables, in column order."""
        return tuple(variable.name for variable in self.variables)

    @property
    def values(self) -> Mapping[str, float]:
        """Values of the variables by short name."""
        return {variable.name: variable.value for variable in self.variables}
