"""Line of a key in a TOML file, which an error message names."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Container, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from toolkit.foundation.errors import InputError

HEADER = re.compile(r"\s*(\[\[?[^\[\]]+\]\]?)\s*(#.*)?$")
KEY = re.compile(r"""\s*((?:[\w-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[\w-]+|"[^"]*"|'[^']*'))*)\s*=""")


@contextmanager
def naming_lines(path: Path, tables: Container[str] = (), changed: Container[str] = ()) -> Iterator[None]:
    """Context in which errors about keys of a file say in which line the keys stand.

    Parameters
    ----------
    path
        The file. Every line of a message that begins with its name, and then names a key, is given the key's line.
    tables
        First keys that are known to be of this file where a message begins with them, without its name; the name is put before it.
    changed
        Keys whose values did not come from the file: they have no line.

    Raises
    ------
    InputError
        As it came, with the lines.
    """
    try:
        yield
    except InputError as error:
        said = _with_lines(str(error), path, tables, changed)
        if said == str(error):
            raise
        raise InputError(said) from error


def _with_lines(message: str, path: Path, tables: Container[str], changed: Container[str]) -> str:
    text, lines = path.read_text(encoding="utf-8-sig"), []
    for problem in message.splitlines():
        bare = problem.removeprefix(f"{path.name}: ")
        place = bare.split(" ")[0].rstrip(":")
        of_file = bare != problem or place.split(".")[0] in tables
        line = line_of(text, place) if of_file and place not in changed else None
        lines.append(problem if line is None else f"{path.name}: {bare} (line {line})")
    return "\n".join(lines)


def line_of(text: str, place: str) -> int | None:
    """Number of the line of a key, or of the table that it should be in.

    Parameters
    ----------
    text
        The file.
    place
        Keys with dots, such as `loads.drive.torque`; numbers count in lists. A key may have dots of its own: `variables.points.A.x`.

    Returns
    -------
    line
        Counted from 1: of the key if it has a line of its own, else of the nearest table or list around it; nothing if the file has none.
    """
    best, found = 0, None
    for number, keys in _keys(text):
        key = ".".join(keys)
        if len(key) > best and f"{place}.".startswith(f"{key}."):
            best, found = len(key), number
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
    """Keys of a header or of an assignment; none of a line that looks like one within a longer text."""
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
