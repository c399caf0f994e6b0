"""What a reduced model was made of: counts of nodes and elements, volume, named places, and what was left out of the mesh file.

A model keeps it as a few attributes, numbers and JSON texts of bounded size, that are checked when they are read.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, TypeVar

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Json

MOST_ENTRIES = 100
"""Groups, masses, kinds left out and remarks that a model keeps of each; it keeps the number of the others."""
LONGEST_NAME, LONGEST_SENTENCE = 100, 400
"""Characters of a name, and of a remark or a reason; the rest is cut off."""
LONGEST_TEXT = 60_000
"""Bytes of one JSON text."""
LISTS = ("groups", "masses", "left_out", "remarks")
"""Fields that are cut at `MOST_ENTRIES`."""

Attributes = dict[str, str | int | float]


class PlaceOfNodes(NamedTuple):
    """Mean position of some nodes, None if there are none, and their number."""

    position: list[float] | None
    nodes: int


class KeptMass(NamedTuple):
    """Concentrated mass of a body."""

    mass: float
    position: list[float]
    nodes: int  # that carry it
    source: str  # keyword or card, with its line


class KeptLeftOut(NamedTuple):
    """Entry of a mesh file that is not part of the body."""

    what: str
    number: int
    why: str


@dataclass(frozen=True)
class Composition:
    """Nodes, elements and named places of a body, and what was left out of its mesh file."""

    nodes: int | None = None
    elements: dict[str, int] = field(default_factory=dict)  # kind -> number
    volume: float | None = None  # from the geometry of the elements alone; None where it is not known
    interface_points: dict[str, int] = field(default_factory=dict)  # name -> number of nodes that carry it
    clamp: PlaceOfNodes | None = None
    groups: dict[str, PlaceOfNodes] = field(default_factory=dict)
    masses: list[KeptMass] = field(default_factory=list)
    left_out: list[KeptLeftOut] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    not_listed: dict[str, int] = field(default_factory=dict)  # one of `LISTS` -> how many more entries it had

    def attributes(self) -> Attributes:
        """Attributes that a model stores, each a number or a JSON text no longer than `LONGEST_TEXT`."""
        found: Attributes = {name: each for name in ("nodes", "volume") if (each := getattr(self, name)) is not None}
        more = dict(self.not_listed)
        for name in ("elements", "interface_points", "clamp", *LISTS):
            entries = getattr(self, name)
            if name in LISTS:
                kept = _shortened(entries)
                more |= {name: more.get(name, 0) + len(entries) - len(kept)} if len(kept) < len(entries) else {}
                entries = kept
            if entries:
                found[name] = _json(entries)
        found |= {"not_listed": _json(more)} if more else {}
        return dict(sorted(found.items()))  # in the order in which files of other programs list them


def plain_text(text: str, longest: int = LONGEST_NAME) -> str:
    """Foreign text without characters that a terminal would obey, cut to the given number of characters."""
    shown = "".join(each if each.isprintable() else "?" for each in text)
    return shown if len(shown) <= longest else shown[: longest - 1] + "…"


def _json(entries: Json) -> str:
    return json.dumps(entries, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def _shortened(entries: Sequence[Json] | Mapping[str, Json]) -> Sequence[Json] | Mapping[str, Json]:
    """First entries of a list or mapping, as many as are allowed and fit into a text."""
    items: list[Any] = list(entries.items()) if isinstance(entries, Mapping) else list(entries)
    size, count = 2, 0
    for item in items[:MOST_ENTRIES]:
        size += len(_json(item).encode()) + 1
        if size > LONGEST_TEXT:
            break
        count += 1
    return dict(items[:count]) if isinstance(entries, Mapping) else items[:count]


def read_composition(attributes: Mapping[str, object], dimension: int) -> Composition:
    """Composition of a body from a model's attributes.

    Raises
    ------
    ValueError
        An attribute is unknown, too long, or not what it has to be; says which and why.
    """
    found: dict[str, Any] = {}
    for name, value in attributes.items():
        if name not in READERS:
            raise ValueError("it has an attribute that no model has")
        try:
            found[name] = READERS[name](_parsed(name, value), dimension)
        except (TypeError, ValueError, RecursionError, KeyError) as error:
            raise ValueError(f"{name} is not what it has to be") from error
    return Composition(**found)


def _parsed(name: str, value: object) -> Json:
    """Value of an attribute that is a number or a JSON text."""
    if name in ("nodes", "volume"):
        if not isinstance(value, int | float):
            raise ValueError("it is no number")
        return value
    if not isinstance(value, str) or len(value.encode()) > LONGEST_TEXT:
        raise ValueError("it is too long or no text")
    return json.loads(value)


def _count(value: Json, _dimension: int = 0) -> int:
    """Whole number that counts something; MATLAB writes it as a floating-point number."""
    value = int(value) if type(value) is float and value.is_integer() else value
    if type(value) is not int or not 0 <= value < 2**53:
        raise ValueError("it counts nothing")
    return value


def _number(value: Json) -> float:
    if (type(value) is not int and type(value) is not float) or not isfinite(value):
        raise ValueError("it is no finite number")
    return float(value)


def _volume(value: Json, _dimension: int) -> float:
    found = _number(value)
    if found <= 0:
        raise ValueError("it is not positive")
    return found


def _text(value: Json, longest: int = LONGEST_NAME) -> str:
    if not isinstance(value, str) or value != plain_text(value, longest):
        raise ValueError("it is no short text")
    return value


def _position(value: Json, dimension: int) -> list[float]:
    if not isinstance(value, list) or len(value) != dimension:
        raise ValueError("it is no place")
    return [_number(each) for each in value]


def _entries(value: Json) -> list[Json]:
    if not isinstance(value, list):
        raise ValueError("it is no list")
    return value


def _place(value: Json, dimension: int) -> PlaceOfNodes:
    position, nodes = _entries(value)
    return PlaceOfNodes(None if position is None else _position(position, dimension), _count(nodes))


def _mass(value: Json, dimension: int) -> KeptMass:
    mass, position, nodes, source = _entries(value)
    return KeptMass(_number(mass), _position(position, dimension), _count(nodes), _text(source))


def _left_out(value: Json, _dimension: int) -> KeptLeftOut:
    what, number, why = _entries(value)
    return KeptLeftOut(_text(what), _count(number), _text(why, LONGEST_SENTENCE))


def _remark(value: Json, _dimension: int) -> str:
    return _text(value, LONGEST_SENTENCE)


T = TypeVar("T")
Reader: TypeAlias = "Callable[[Json, int], T]"
"""What checks a value that was read, given the dimension of space, and makes of it what a composition keeps."""


def _table(reader: Reader[T]) -> Reader[dict[str, T]]:
    def read(value: Json, dimension: int) -> dict[str, T]:
        if not isinstance(value, dict) or len(value) > LONGEST_TEXT:
            raise ValueError("it is no table")
        return {_text(name): reader(each, dimension) for name, each in value.items()}

    return read


def _list(reader: Reader[T]) -> Reader[list[T]]:
    def read(value: Json, dimension: int) -> list[T]:
        if not isinstance(value, list) or len(value) > MOST_ENTRIES:
            raise ValueError("it is no list, or too long")
        return [reader(each, dimension) for each in value]

    return read


READERS: dict[str, Reader[object]] = {
    "nodes": _count,
    "volume": _volume,
    "elements": _table(_count),
    "interface_points": _table(_count),
    "clamp": _place,
    "groups": _table(_place),
    "masses": _list(_mass),
    "left_out": _list(_left_out),
    "remarks": _list(_remark),
    "not_listed": _table(_count),
}
"""Attribute -> what checks its content."""


def place_of(positions: Sequence[Sequence[float]]) -> PlaceOfNodes:
    """The mean of the positions of some nodes, and their number."""
    count = len(positions)
    return PlaceOfNodes([float(sum(axis)) / count for axis in zip(*positions, strict=True)] if count else None, count)
