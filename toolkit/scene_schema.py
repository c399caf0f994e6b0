"""The JSON schema of scene files, made from the classes that read them, so that editors complete and check what is written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from toolkit.bodies.body import Body
from toolkit.description import Description
from toolkit.joints.joint import Joint
from toolkit.loads.gravity import Gravity
from toolkit.loads.load import Load
from toolkit.point import BodyPoint
from toolkit.responses.catalogue import Response
from toolkit.responses.instant import Instant
from toolkit.run_options import RunOptions
from toolkit.scene_file import Scene
from toolkit.units import UNIT_SYSTEMS

DRAFT = "http://json-schema.org/draft-07/schema#"
"""The newest version that the editors' TOML plugins understand."""

_REFERENCE = "#/$defs/{model}"


def scene_schema() -> dict[str, Any]:
    """JSON schema of scene.toml, with all kinds that the toolkit brings; see `tidy` for its dialect."""
    kinds: dict[str, Mapping[str, type]] = {
        "body": Body.kinds,
        "joint": Joint.kinds,
        "load": {**Load.kinds, Gravity.kind: Gravity},
        "response": Response.kinds,
    }
    definitions: dict[str, Any] = {}
    for group, known in kinds.items():
        own = sorted(kind for kind, described in known.items() if described.__module__.startswith("toolkit."))
        definitions |= {f"{group}-{kind}": _with_type(_schema(known[kind], definitions), kind) for kind in own}
        definitions[group] = _one_of(f"{group}-{kind}" for kind in own)
    instants = sorted(f"response-{kind}" for kind in Instant.kinds)
    definitions["instant"] = _one_of(name for name in instants if name in definitions)
    definitions["response-time-integral"]["properties"]["of"] = {"$ref": "#/$defs/instant"}
    definitions["body-point"] = _schema(BodyPoint, definitions)
    coordinates = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2, "description": "[x, y]"}
    solver = _schema(RunOptions, definitions)
    root = {
        "$schema": DRAFT,
        "title": "A scene of ffrf-toolkit",
        "description": Scene.__doc__,
        "type": "object",
        "properties": {
            "units": {"enum": list(UNIT_SYSTEMS)},
            "points": _table({"anyOf": [coordinates, {"$ref": "#/$defs/body-point"}]}),
            **{group: _table({"$ref": f"#/$defs/{kind}"}) for group, kind in _GROUPS.items()},
            "design": _table({"type": "string", "description": "path of a number, for example points.A.x"}),
            "solver": solver,
        },
        "required": ["units", "bodies"],
        "additionalProperties": False,
        "$defs": dict(sorted(definitions.items())),
    }
    return tidy(root)


_GROUPS = {"bodies": "body", "joints": "joint", "loads": "load", "responses": "response"}


def _schema(kind: type, definitions: dict[str, Any]) -> dict[str, Any]:
    """Schema of one class; what it refers to goes to the definitions."""
    assert issubclass(kind, Description)
    schema = kind.model_json_schema(ref_template=_REFERENCE)
    definitions.update(schema.pop("$defs", {}))
    return schema


def _with_type(schema: dict[str, Any], kind: str) -> dict[str, Any]:
    """The schema of a table that names its kind under `type`."""
    properties = {"type": {"const": kind}, **schema.get("properties", {})}
    return {**schema, "properties": properties}


def _one_of(names: Iterable[str]) -> dict[str, Any]:
    return {"oneOf": [{"$ref": _REFERENCE.format(model=name)} for name in names]}


def _table(item: dict[str, Any]) -> dict[str, Any]:
    """Any names, all with items of one kind."""
    return {"type": "object", "additionalProperties": item}


def tidy(schema: Any) -> Any:
    """A pydantic schema in draft 7 and for TOML: tuples as arrays of one kind, no null, no titles made up from names."""
    if isinstance(schema, list):
        return [tidy(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
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
