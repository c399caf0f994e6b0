"""Hypothesis strategies that spoil a valid TOML file: values replaced, keys deleted, tables doubled, types exchanged, names mangled."""

from __future__ import annotations

import copy
import datetime
import json
import math
from collections.abc import Callable
from typing import Any

from hypothesis import strategies as st

NUMBERS = [0, -1, 1, 2, 10**20, -(10**30), 2**63, 10**400, 0.0, -0.0, 1e-320, 5e-324, 1e-200, 1e-30, 1e-9, 0.5, 3, 1e9, 1e20, 1e100, 1e155,
           1e308,
           -1e308, -1e19, 1e19, math.inf, -math.inf, math.nan]  # fmt: skip
NAMES = ["", " ", "ground", "a.b", "../../etc/passwd", "/", "a/b", "skin.h5", "\0", "\x1b[31m", "ﬂügel", "名前", "🛩",
         "x" * 10_000, "x", "y", "0", "²",
         "type", "self", "__class__", "directory", "{0}", "%s", "\u202e", "C", "A", "hub", "time"]  # fmt: skip
OTHERS = [True, False, [], {}, [[]], [{}], {"type": []}, {"type": {}}, {"type": "sum", "terms": []}, [1, 2], [1.0, "x"], [0.0] * 1000,
          datetime.date(2020, 1, 1), datetime.datetime(2020, 1, 1), datetime.time(1, 2)]  # fmt: skip

values = st.one_of(
    st.sampled_from(NUMBERS), st.sampled_from(NAMES), st.sampled_from(OTHERS), st.floats(), st.integers(), st.text(max_size=20)
)
names = st.one_of(st.sampled_from(NAMES), st.text(max_size=10))

Place = tuple[Any, Any]
"""A table or list, and a key of it."""


@st.composite
def spoilt(draw: Callable, tables: list[dict[str, Any]]) -> dict[str, Any]:
    """One of the tables with one to three mistakes."""
    table = copy.deepcopy(tables[draw(st.integers(0, len(tables) - 1))])
    for _ in range(draw(st.integers(1, 3))):
        found = places(table)
        if found:
            mistake = draw(st.sampled_from(MISTAKES))
            mistake(draw, found, *found[draw(st.integers(0, len(found) - 1))])
    return table


def places(owner: Any) -> list[Place]:
    """All places of a nested table."""
    keys = list(owner) if isinstance(owner, dict) else range(len(owner)) if isinstance(owner, list) else []
    return [place for key in keys for place in [(owner, key), *places(owner[key])]]


def _replace(draw: Callable, _: list[Place], owner: Any, key: Any) -> None:
    owner[key] = copy.deepcopy(draw(values))


def _delete(_draw: Callable, _: list[Place], owner: Any, key: Any) -> None:
    del owner[key]


def _double(draw: Callable, _: list[Place], owner: Any, key: Any) -> None:
    again = copy.deepcopy(owner[key])
    if isinstance(owner, dict):
        owner[draw(names)] = again
    else:
        owner.append(again)


def _rename(draw: Callable, _: list[Place], owner: Any, key: Any) -> None:
    if isinstance(owner, dict):
        owner[draw(names)] = owner.pop(key)


def _exchange(draw: Callable, found: list[Place], owner: Any, key: Any) -> None:
    other, its_key = found[draw(st.integers(0, len(found) - 1))]
    owner[key] = copy.deepcopy(other[its_key])


def _wrap(draw: Callable, _: list[Place], owner: Any, key: Any) -> None:
    for _unused in range(draw(st.sampled_from([1, 2, 60]))):
        owner[key] = [owner[key]] if draw(st.booleans()) else {draw(names): owner[key]}


def _scale(draw: Callable, found: list[Place], _owner: Any, _key: Any) -> None:
    """The only mistake that leaves a legal scene: some number has another size."""
    numbers = [place for place in found if type(place[0][place[1]]) in (int, float)]
    if numbers:
        owner, key = numbers[draw(st.integers(0, len(numbers) - 1))]
        owner[key] = draw(st.sampled_from([-1, 0, 2.0, 1e3, 1e-3, 1e6, 1e-6, 1e12, 1e-12, 1e18, 1e-18])) * owner[key]


MISTAKES = [_replace, _replace, _delete, _double, _rename, _exchange, _wrap, _scale, _scale, _scale]


def as_toml(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_escaped(key)} = {as_toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(as_toml, value)) + "]"
    if isinstance(value, str):
        return _escaped(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int):
        return str(value) if abs(value) < 10**100 else f"{value:#x}"
    return value.isoformat() if hasattr(value, "isoformat") else repr(value)


def document(table: dict[str, Any]) -> str:
    """A whole file."""
    return "".join(f"{_escaped(key)} = {as_toml(value)}\n" for key, value in table.items())


def _escaped(text: str) -> str:
    """JSON's text without surrogates, which TOML does not know."""
    return json.dumps(text.encode("utf-8", "replace").decode(), ensure_ascii=False).replace("\x7f", "\\u007f")
