"""The content of an input file checked against its schema, and what is said about every wrong key."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import NoneType
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.toml_lines import line_of
from toolkit.foundation.listed_names import SHORT, meant

File = TypeVar("File", bound=BaseModel)


def validated(schema: type[File], content: Mapping[str, Any], whose: str, source: Path | None = None) -> File:
    """Content of a file, checked against its schema; `whose` it is begins the message, and lines are those of the source.

    Raises
    ------
    InputError
        Names every key that is unknown, missing or has an invalid value.
    """
    try:
        return schema.model_validate(content)
    except ValidationError as error:
        text = source.read_text(encoding="utf-8-sig") if source is not None and source.is_file() else ""
        problems = "\n".join(f"  {explain(item, schema)}{_line(text, item)}" for item in error.errors())
        raise InputError(f"{whose} cannot be used:\n{problems}") from error


def put(content: dict[str, Any], keys: Sequence[Any], value: Any) -> None:
    """Set a table (`basis`), a key in one (`skin`, `elements`), or an item of a list there (`nodes`, `A`, 0)."""
    *tables, last = keys
    table: Any = content
    for name in tables:
        table = table.setdefault(name, {})
    table[last] = value


def explain(item: Any, schema: type[BaseModel]) -> str:
    """Line on one wrong key of a file with this schema: where it is, what is wrong, what would be right."""
    location = _location(item)
    key = ".".join(map(str, location))
    if item["type"] == "extra_forbidden":
        known = _keys(schema, location[:-1])
        return f"{key}: unknown key{meant(str(location[-1]), known)}; possible here: {', '.join(known)}."
    if item["type"] == "missing":
        return f"{key}: this key is missing; add it."
    reason = item["msg"].removeprefix("Value error, ")
    value = "" if isinstance(item["input"], dict) else f" (given: {SHORT.repr(item['input'])})"
    return f"{key}: {reason[0].lower()}{reason[1:]}{value}.".removeprefix(": ")


def _location(item: Any) -> tuple[str | int, ...]:
    """Keys that lead to what is wrong, without pydantic's mark for a key itself."""
    location: tuple[str | int, ...] = item["loc"][:-2] if item["loc"][-1:] == ("[key]",) else item["loc"]
    return location


def _line(text: str, item: Any) -> str:
    """Line number of a wrong key, to append; empty where the file has none."""
    line = line_of(text, ".".join(map(str, _location(item))))
    return "" if line is None else f" (line {line})"


def _keys(schema: type[BaseModel], location: tuple[str | int, ...]) -> list[str]:
    """Keys of the table at a location of the schema."""
    table: Any = schema
    for part in location:
        of_group = get_args(table)  # (InterfaceName, Place) of dict, (BeamTable,) of list
        table = of_group[-1] if of_group else _optional(table.model_fields[str(part)].annotation)
    return [field.alias or name for name, field in table.model_fields.items()]


def _optional(annotation: Any) -> Any:
    """Type of a key, without the None of one that may be left out."""
    options = get_args(annotation)
    return options[0] if options[1:] == (NoneType,) else annotation
