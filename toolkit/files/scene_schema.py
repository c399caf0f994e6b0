"""The JSON schema of scene files, made from the classes that read them, so that editors complete and check what is written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from pydantic.json_schema import JsonSchemaValue

from toolkit.components.curves.catalogue import Curve
from toolkit.components.curves.curve import PLACEHOLDER
from toolkit.description.description import Description
from toolkit.description.design import BodyPoint, CommonVariable
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import Scene
from toolkit.foundation.units import UNIT_SYSTEMS
from toolkit.responses.catalogue import Response
from toolkit.responses.over_time import OverTime
from toolkit.responses.response import Instant
from toolkit.scene.kinds import kinds_of

if TYPE_CHECKING:
    from pydantic.json_schema import JsonSchemaValue

DRAFT = "http://json-schema.org/draft-07/schema#"
"""The newest version that the editors' TOML plugins understand."""

_REFERENCE = "#/$defs/{model}"


def scene_schema() -> JsonSchemaValue:
    """JSON schema of scene.toml, with all kinds that the toolkit brings; see `tidy` for its dialect.

    A scene is checked against the kinds of its dimension; the tables themselves name those of both, because editors complete from there.
    """
    definitions: JsonSchemaValue = {}
    for dimension, prefix in PREFIXES.items():
        for group, known in kinds_of(dimension).items():
            _define(f"{prefix}{_GROUPS[group]}", known, definitions)
    _define("response", Response.kinds, definitions)
    _define("curve", Curve.kinds, definitions)
    instants = sorted(f"response-{kind}" for kind in Instant.kinds)
    definitions["instant"] = _one_of(name for name in instants if name in definitions)
    for kind in (kind for kind, described in Response.kinds.items() if issubclass(described, OverTime)):
        over_time = definitions.get(f"response-{kind}", {}).get("properties", {})
        if "of" in over_time:
            over_time["of"] = {"$ref": "#/$defs/instant"}
    definitions["body-point"] = _schema(BodyPoint, definitions)
    solver = _schema(RunOptions, definitions)
    path = {"type": "string", "description": "path of a number, for example points.A.x"}
    definitions["CommonVariable"] = _schema(CommonVariable, definitions)
    either = {name: _table({"anyOf": [_item(name, dimension) for dimension in PREFIXES]}) for name in ("points", *_GROUPS)}
    root = {
        "$schema": DRAFT,
        "title": "A scene of ffrf-toolkit",
        "description": Scene.__doc__,
        "type": "object",
        "properties": {
            "units": {"enum": list(UNIT_SYSTEMS)},
            "dimension": {"enum": list(PREFIXES), "default": 2, "description": "of space; it stands at the top of the file"},
            **either,
            "responses": _table({"$ref": "#/$defs/response"}),
            "design": _table({"anyOf": [path, {"$ref": "#/$defs/CommonVariable"}]}),
            "solver": solver,
        },
        "required": ["units", "bodies"],
        "additionalProperties": False,
        "if": {"properties": {"dimension": {"const": 3}}, "required": ["dimension"]},
        "then": _tables(3),
        "else": _tables(2),
        "$defs": dict(sorted(definitions.items())),
    }
    return tidy(root)


PREFIXES = {2: "", 3: "spatial-"}
"""Dimension of a scene -> beginning of the names of its definitions."""
_GROUPS = {"bodies": "body", "joints": "joint", "loads": "load"}


def _define(group: str, known: Mapping[str, type], definitions: JsonSchemaValue) -> None:
    """Add definitions of all kinds of a group that the toolkit brings, and one that is any of them.

    A kind that is in space what it is in the plane has one definition.
    """
    names = []
    for kind in sorted(kind for kind, described in known.items() if described.__module__.startswith("toolkit.")):
        found = _with_type(_schema(known[kind], definitions), kind)
        name = f"{group}-{kind}".removeprefix(PREFIXES[3])
        names.append(name if tidy(definitions.get(name, found)) == tidy(found) else f"{group}-{kind}")
        definitions[names[-1]] = found
    definitions[group] = _one_of(names)


def _tables(dimension: int) -> JsonSchemaValue:
    """Schema of the tables of a scene of one dimension."""
    return {"properties": {name: _table(_item(name, dimension)) for name in ("points", *_GROUPS)}}


def _item(group: str, dimension: int) -> JsonSchemaValue:
    """Schema of an item under a name of a group."""
    if group != "points":
        return {"$ref": f"#/$defs/{PREFIXES[dimension]}{_GROUPS[group]}"}
    words = "[" + ", ".join("xyz"[:dimension]) + "]"
    place = {"type": "array", "items": {"type": "number"}, "minItems": dimension, "maxItems": dimension, "description": words}
    return {"anyOf": [place, {"$ref": "#/$defs/body-point"}]}


def _schema(kind: type, definitions: JsonSchemaValue) -> JsonSchemaValue:
    """Schema of one class; what it refers to goes to the definitions."""
    assert issubclass(kind, Description)
    schema = kind.model_json_schema(ref_template=_REFERENCE)
    definitions.update(schema.pop("$defs", {}))
    return schema


def _with_type(schema: JsonSchemaValue, kind: str) -> JsonSchemaValue:
    """Schema of a table that names its kind under `type`."""
    properties = {"type": {"const": kind}, **schema.get("properties", {})}
    return {**schema, "properties": properties}


def _one_of(names: Iterable[str]) -> JsonSchemaValue:
    return {"oneOf": [{"$ref": _REFERENCE.format(model=name)} for name in names]}


def _table(item: JsonSchemaValue) -> JsonSchemaValue:
    """Schema of a table with any names, all for items of one kind."""
    return {"type": "object", "additionalProperties": item}


def tidy(schema: Any) -> Any:
    """Pydantic schema in draft 7 and for TOML: tuples as arrays of one kind, no null, no titles made up from names."""
    if isinstance(schema, list):
        return [tidy(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if schema.get("$comment") == PLACEHOLDER:
        return {**schema, "$ref": "#/$defs/curve"}
    found = {key: tidy(item) for key, item in schema.items() if key != "discriminator" and item is not None}
    if isinstance(found.get("title"), str) and "$schema" not in found:
        del found["title"]
    if "const" in found.get("properties", {}).get("type", {}):
        found["required"] = ["type", *(key for key in found.get("required", []) if key != "type")]
    if "prefixItems" in found:
        found["items"] = found.pop("prefixItems")[0]
    options = found.get("anyOf", [])
    if {"type": "null"} in options:
        rest = [option for option in options if option != {"type": "null"}]
        del found["anyOf"]
        found |= rest[0] if len(rest) == 1 else {"anyOf": rest}
    return found
