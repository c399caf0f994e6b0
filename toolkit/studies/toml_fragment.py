"""Tables as TOML text, for a person to paste."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def toml_table(name: str, content: Mapping[str, Any]) -> str:
    """A table under its header; tables in it are written inline."""
    return "\n".join([f"[{name}]", *(f"{key} = {toml_value(value)}" for key, value in content.items())])


def toml_value(value: Any) -> str:
    """One value, exactly."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        inside = ", ".join(f"{key} = {toml_value(each)}" for key, each in value.items())
        return f"{{ {inside} }}" if inside else "{}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(toml_value, value))}]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
