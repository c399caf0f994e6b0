"""The layout of a reduced-model file, from the dataclasses that are written into it."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

from docs.generators.comments import meanings, words
from docs.generators.key_tables import cell
from toolkit.reduced_model.file import MAPS, NAMED, OPTIONAL, PARTS, SCHEMA, SCHEMA_VERSION, SPATIAL_PARTS
from toolkit.reduced_model.model import ReducedModel


def layout() -> str:
    """Attributes, then one section per group."""
    meaning = meanings(ReducedModel)
    single = [item.name for item in fields(ReducedModel) if item.compare and item.name not in (*PARTS, *MAPS, *OPTIONAL)]
    attributes = {"schema": f'"{SCHEMA}"', "schema_version": str(SCHEMA_VERSION)} | {n: meaning.get(n, "") for n in single}
    groups = {f"{name}/": meaning.get(name, "") for name in (*MAPS, *OPTIONAL)}
    return "\n\n".join(
        [
            f"### Attributes of the file\n\n{_table(attributes)}",
            f"### Groups that hold their content as attributes\n\n{_table(groups)}",
            *(_section(name, meaning.get(name, "")) for name in PARTS),
        ]
    )


def _section(name: str, meaning: str) -> str:
    kind = PARTS[name]
    (item,) = [item for item in fields(ReducedModel) if item.name == name]
    head = f"### {name}/\n\n" + (
        f"{meaning[0].upper()}{meaning[1:]}{': one group for each name' * (name in NAMED)}.\n\n" if meaning else ""
    )
    if not is_dataclass(kind):
        return head + "Datasets of the names and shapes of `invariants/`, those alone that are not zero."
    below = f"{name}/NAME/" if "dict" in str(item.type) else f"{name}/"
    found = head + _kind(kind, below)
    return found + f"\n\nIn space: {_kind(SPATIAL_PARTS[name], below)}" if name in SPATIAL_PARTS else found


def _kind(kind: Any, below: str) -> str:
    """What a class says of itself, and its fields."""
    inside = meanings(kind)
    rows = {f"{below}{each.name}": inside.get(each.name, "") for each in fields(kind)}
    return f"{words(kind)}\n\nIn the reference: [`{kind.__name__}`][{kind.__module__}.{kind.__name__}].\n\n{_table(rows)}"


def _table(rows: dict[str, str]) -> str:
    return "\n".join(
        ["| name | shape or meaning |", "|---|---|", *(f"| `{name}` | {cell(text)} |" for name, text in rows.items())]
    )
