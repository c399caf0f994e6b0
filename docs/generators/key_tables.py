"""The keys of a table in a TOML file, from the pydantic class that reads it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from docs.generators.comments import meanings
from toolkit.components.curves.curve import PLACEHOLDER
from toolkit.description.description import Quantity

BOUNDS = {"exclusiveMinimum": "&gt;", "minimum": "&ge;", "exclusiveMaximum": "&lt;", "maximum": "&le;"}
SIMPLE = {"number": "number", "integer": "whole number", "string": "text", "boolean": "`true` or `false`"}
SECTIONS = {
    "points": ("Point", "BodyPoint"),
    "design": ("CommonVariable",),
    "solver": ("RunOptions",),
    "baumgarte": ("Baumgarte",),
    "start-and-end": ("ContourPoint",),
    "places": ("Place",),
}
"""Where the pages describe the tables that other tables hold, by class."""


def key_table(*models: type[BaseModel], without: Iterable[str] = (), marks: Iterable[str] = ()) -> str:
    """One row per key: what may stand there, the default, and what it means; of several models each with its mark, where they differ."""
    found = [_key_rows(model, without) for model in models]
    rows = [_row(cells) for cells in found[0] if all(cells in others for others in found)]
    for mark, cells in [(mark, cells) for mark, own in zip(marks, found, strict=False) for cells in own]:
        if _row(cells) not in rows:
            rows.append(_row((*cells[:3], f"{mark}: {cells[3]}" if mark else cells[3])))
    return "\n".join(["| key | value | default | meaning |", "|---|---|---|---|", *rows]) if rows else "No keys of its own."


def _row(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _key_rows(model: type[BaseModel], without: Iterable[str]) -> list[tuple[str, str, str, str]]:
    """Key, what may stand there, default and meaning of every key of a model."""
    schema = model.model_json_schema()
    if "$ref" in schema:
        schema = schema["$defs"][schema["$ref"].rpartition("/")[2]]
    meaning = {field.alias or name: meanings(model).get(name, "") for name, field in model.model_fields.items()}
    measures = {field.alias or name: measured(field) for name, field in model.model_fields.items()}
    rows = []
    for key, value in schema.get("properties", {}).items():
        if key not in {"type", *without}:
            default = "required" if key in schema.get("required", ()) else default_of(value)
            rows.append((f"`{key}`", in_words(value) + measures.get(key, ""), default, cell(meaning.get(key, ""))))
    if schema.get("additionalProperties") not in (None, False):
        rows.append(("any parameter of the reduced model", "number", "nominal value", "Replaces the nominal value."))
    return rows


def measured(field: FieldInfo) -> str:
    """What the numbers of a field measure, as it stands beside the field; nothing for pure numbers."""
    words = next((each.each for each in field.metadata if isinstance(each, Quantity)), ())
    return f": {', '.join(words)}" if any(word != "none" for word in words) else ""


def cell(text: str) -> str:
    """Text that may stand in a cell."""
    return text.replace("|", "&#124;").replace("<", "&lt;").replace("*", "&#42;")


def default_of(schema: Mapping[str, Any]) -> str:
    """The default as it would be written; a table's defaults stand with its own keys."""
    default = schema.get("default")
    if default is None or (isinstance(default, dict) and "type" not in default):
        return ""
    return f"`{toml(default)}`"


def toml(value: Any) -> str:
    """A value as a TOML file has it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml, value)) + "]"
    return f'"{value}"' if isinstance(value, str) else repr(value)


def in_words(schema: Mapping[str, Any]) -> str:
    """What a JSON schema allows."""
    if "$ref" in schema:
        return _described_elsewhere(schema["$ref"].rpartition("/")[2])
    if schema.get("$comment") == PLACEHOLDER:
        return "[table](#curves)"
    if "const" in schema:
        return f"`{toml(schema['const'])}`"
    if "enum" in schema:
        return " or ".join(f"`{toml(value)}`" for value in schema["enum"])
    for choice in ("anyOf", "oneOf"):
        if choice in schema:
            return " or ".join(dict.fromkeys(in_words(part) for part in schema[choice] if part.get("type") != "null"))
    if "prefixItems" in schema:
        return "[" + ", ".join(map(in_words, schema["prefixItems"])) + "]"
    if schema.get("type") == "array":
        return f"list: {in_words(schema['items'])}"
    inside = schema.get("additionalProperties")
    if isinstance(inside, Mapping) and "prefixItems" in inside:
        return f"table of {in_words(inside)}"
    bounds = " and ".join(f"{sign} {schema[bound]:g}" for bound, sign in BOUNDS.items() if bound in schema)
    return f"{SIMPLE.get(schema.get('type', ''), 'table')} {bounds}".strip()


def _described_elsewhere(name: str) -> str:
    section = next((section for section, names in SECTIONS.items() if name in names), None)
    return "table" if section is None else f"[table](#{section})"
