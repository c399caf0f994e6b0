"""TOML files read within limits: what no scene and no skin can need is refused before anything can choke on it."""

from __future__ import annotations

import re
import tomllib
from os.path import isdir
from pathlib import Path
from typing import Any

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.meant_path import meant_path
from toolkit.foundation.files.regular_file import read_start
from toolkit.foundation.listed_names import listed

LARGEST_FILE = 10_000_000
"""Bytes; a scene of a thousand bodies has a hundredth of it."""
DEEPEST = 30
"""Levels of tables and lists within each other."""
HDF5 = b"\x89HDF\r\n"
"""First bytes of a file of numbers (HDF5)."""
LONG_KEY = re.compile(r"""(?<![\w-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){100}""")
"""The time that a key takes grows with more than the square of its parts, half a minute for a file of 64 kB."""


def read_toml(path: Path, what: str) -> dict[str, Any]:
    """Tables of a TOML file; `what` it should be is named if it is missing.

    Raises
    ------
    InputError
        The file is missing, too large, or no TOML.
    """
    try:
        content = read_start(path, LARGEST_FILE + 1)
    except OSError as error:
        found = sorted(map(str, path.glob("*.toml"))) if isdir(path) else []  # no error of its own for any path
        inside = f"; in this folder there are: {listed(found)}" if found else ""
        raise InputError(
            f"{str(path)!r} cannot be read ({error.strerror}{meant_path(path, error)}). Give the path of {what}{inside}."
        ) from error
    if len(content) > LARGEST_FILE:
        raise InputError(f"{str(path)!r} has more than {LARGEST_FILE} bytes. Give the path of {what}.")
    if content.startswith(HDF5):
        raise InputError(
            f"{str(path)!r} holds numbers in HDF5, as reduced models and results do, and is not {what}. ffrf inspect tells what is in it."
        )
    try:
        return parse_toml(content.decode("utf-8-sig"))
    except ValueError as error:
        remedy = "Fix that line" if path.suffix == ".toml" else f"Fix that line, or give the path of {what}"
        raise InputError(f"{str(path)!r} is not readable as TOML: {error}. {remedy}.") from error


def parse_toml(text: str) -> dict[str, Any]:
    """Tables of a TOML text; raises ValueError if it is no TOML, or has numbers or levels beyond what TOML has to offer."""
    if LONG_KEY.search(text):
        raise ValueError("a key has more than 100 parts between dots")
    try:
        table = tomllib.loads(text)
    except RecursionError:
        raise ValueError(f"tables or lists are nested more than {DEEPEST} deep") from None
    _check(table, 0)
    return table


def _check(value: Any, depth: int) -> None:
    if depth > DEEPEST:
        raise ValueError(f"tables or lists are nested more than {DEEPEST} deep")
    if isinstance(value, (dict, list)):
        for item in value.values() if isinstance(value, dict) else value:
            _check(item, depth + 1)
    elif isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise ValueError("it holds a whole number of more than 64 bits")
