"""TOML files read within limits: what no scene and no skin can need is refused before anything can choke on it."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Container, Iterator, Mapping
from contextlib import contextmanager
from os.path import isdir
from pathlib import Path
from typing import Any, Literal

from toolkit.foundation.errors import InputError, listed
from toolkit.foundation.files.safe_files import meant_path, read_start

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


Kind = Literal["scene", "study", "body"]

OF_SCENES = {"bodies", "joints", "loads"}
OF_BODIES = {"airfoil", "mesh", "matrices", "beams"}
OF_STUDIES = {"variables", "objective", "analysis", "uncertain", "constraints"}
NAMES: dict[Kind, str] = {"scene": "a scene", "study": "a study", "body": "a file that a reduced model is built from"}


def refuse_other(table: Mapping[str, object], path: Path, wanted: Kind) -> None:
    """Refuse a file of another kind, before all its keys are unknown.

    Raises
    ------
    InputError
        It says what the file is, and what to type.
    """
    kind = _kind(table)
    if kind is None or kind == wanted:
        return
    told = (
        f"{path.name} is a study of the scene {str(table['scene'])[:80]!r}"
        if kind == "study"
        else f"{path.name} is {NAMES[kind]}"
    )
    raise InputError(f"{told}, not {NAMES[wanted]}. {_ADVICE[wanted, kind](path)}")


def _kind(table: Mapping[str, object]) -> Kind | None:
    """Kind of a file, "scene", "study" or "body"; None if its keys do not say."""
    if table.keys() & OF_SCENES:
        return "scene"
    if "scene" in table and table.keys() & OF_STUDIES:
        return "study"
    return "body" if table.keys() & OF_BODIES and "responses" not in table else None


def _of_study(path: Path) -> str:
    return f"`ffrf optimize {path}`, `ffrf sweep` and `ffrf uncertainty` take it"


def _where_a_study_is(path: Path) -> str:
    beside = path.with_name("study.toml")
    if beside.is_file():
        return f"Beside it is a study: give {beside}."
    return (
        f"A study is a file of its own, which begins with scene = {path.name!r} and says under [variables] which numbers may be changed; "
        "`ffrf new wing` writes one."
    )


_ADVICE = {
    ("scene", "study"): lambda path: f"Give that scene here; {_of_study(path)}.",
    ("scene", "body"): lambda path: (
        f"Build its reduced model with `ffrf-preprocess {path}`, and name that as the model of a body in a scene."
    ),
    ("study", "scene"): _where_a_study_is,
    ("study", "body"): lambda path: (
        f"Build its reduced model with `ffrf-preprocess {path}`, for a scene of which a study says what may be changed."
    ),
    ("body", "scene"): lambda path: (
        f"Analyse it with `ffrf simulate {path}`; what is built here are the files that describe its flexible bodies."
    ),
    ("body", "study"): lambda path: f"What is built here are the files that describe flexible bodies; {_of_study(path)}.",
}
"""Advice by (kind that was wanted, kind that is there): what to do."""


LARGEST_FILE = 10_000_000
"""Bytes; a scene of a thousand bodies has a hundredth of it."""
DEEPEST_TABLE = 30
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
        raise ValueError(f"tables or lists are nested more than {DEEPEST_TABLE} deep") from None
    _check(table, 0)
    return table


def _check(value: object, depth: int) -> None:
    if depth > DEEPEST_TABLE:
        raise ValueError(f"tables or lists are nested more than {DEEPEST_TABLE} deep")
    if isinstance(value, (dict, list)):
        for item in value.values() if isinstance(value, dict) else value:
            _check(item, depth + 1)
    elif isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise ValueError("it holds a whole number of more than 64 bits")
