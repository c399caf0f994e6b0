"""Where a key of a TOML file stands: the line that an error message names."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import Any

HEADER = re.compile(r"\s*(\[\[?[^\[\]]+\]\]?)\s*(#.*)?$")
KEY = re.compile(r"""\s*((?:[\w-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[\w-]+|"[^"]*"|'[^']*'))*)\s*=""")


def line_of(text: str, place: str) -> int | None:
    """The line of a key, or of the table that it should be in.

    Parameters
    ----------
    text
        The file.
    place
        Keys with dots, such as `loads.drive.torque`; numbers count in lists.

    Returns
    -------
    line
        Counted from 1: of the key if it has a line of its own, else of the nearest table or list around it; nothing if the file has none.
    """
    parts = place.split(".")
    best, found = 0, None
    for number, keys in _keys(text):
        if len(keys) > best and keys == parts[: len(keys)]:
            best, found = len(keys), number
    return found


def _keys(text: str) -> list[tuple[int, list[str]]]:
    """Every line that begins a table or a key, with the path to it."""
    table: list[str] = []
    found: list[tuple[int, list[str]]] = []
    for number, line in enumerate(text.splitlines(), 1):
        if header := HEADER.match(line):
            table = _path(header[1] + "\n")
            found.append((number, table))
        elif key := KEY.match(line):
            found.append((number, table + _path(f"{key[1]} = 0\n")))
    return found


def _path(line: str) -> list[str]:
    """The keys of a header or of an assignment; none of a line that looks like one within a longer text."""
    try:
        at: Any = tomllib.loads(line)
    except tomllib.TOMLDecodeError:
        return []
    path = []
    while isinstance(at, (Mapping, list)) and at:
        if isinstance(at, list):
            at = at[0]
            continue
        key, at = next(iter(at.items()))
        path.append(key)
    return path
