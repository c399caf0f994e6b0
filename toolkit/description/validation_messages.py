"""Messages on what pydantic found wrong: the key as it stands in the file, and what would be right."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, TypeGuard, get_args

from pydantic import BaseModel, ValidationError

from toolkit.foundation.errors import SHORT, meant

if TYPE_CHECKING:
    from _typeshed import SupportsGetItem
    from pydantic_core import ErrorDetails


def messages(error: ValidationError, kind: type[BaseModel], value: object, where: str, nested: Mapping[str, type]) -> list[str]:
    """One line per mistake: where it is, what is wrong, what is possible.

    Parameters
    ----------
    kind, value : class that was wanted, and what was given for it
    where : path of the value in the file
    nested : classes of tables below it that have a `type`
    """
    lines = []
    for each in _causes(error):
        keys, owner = _walk(kind, value, each, nested)
        place = ".".join([*([where] if where else []), *keys])
        lines.append((f"{place}: " if place else "") + _said(each, owner))
    return list(dict.fromkeys(lines))


def _causes(error: ValidationError) -> list[ErrorDetails]:
    """Mistakes that do not follow from others: a list is not too short because its entries are wrong."""
    found = error.errors()
    below = {each["loc"][:depth] for each in found for depth in range(len(each["loc"]))}
    return [each for each in found if each["type"] != "too_short" or each["loc"] not in below]


def _walk(
    kind: type[BaseModel], value: object, error: ErrorDetails, nested: Mapping[str, type]
) -> tuple[list[str], type[BaseModel]]:
    """Keys that a person wrote, without pydantic's own marks for unions, and the class of the innermost table."""
    keys: list[str] = []
    location = error["loc"]
    for depth, part in enumerate(location):
        last = depth == len(location) - 1
        if _has(value, part):
            value = value[part]
        elif not (last and error["type"] == "missing"):
            continue
        keys.append(str(part))
        if isinstance(value, Mapping) and not last:
            kind = nested.get(str(value.get("type")), _field_class(kind, part))
    return keys, kind


def _has(value: object, part: int | str) -> TypeGuard[SupportsGetItem[int | str, object]]:
    if isinstance(value, (list, tuple)):
        return isinstance(part, int) and part < len(value)
    return isinstance(value, Mapping) and part in value


def _field_class(kind: type[BaseModel], part: int | str) -> type[BaseModel]:
    field = kind.model_fields.get(part) if isinstance(part, str) else None
    return kind if field is None else next(_classes(field.annotation), kind)


def _classes(annotation: object) -> Iterator[type[BaseModel]]:
    """Classes of tables in an annotation."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _classes(part)


def _said(error: ErrorDetails, owner: type[BaseModel]) -> str:
    possible = ", ".join(name for name in owner.model_fields if name != "directory")
    if error["type"] == "extra_forbidden":
        return f"unknown key{meant(str(error['loc'][-1]), owner.model_fields)}; possible here: {possible}."
    if error["type"] == "missing":
        if isinstance(error["loc"][-1], int):
            return "this entry is missing, the list is too short."
        return f"this key is missing; needed or possible here: {possible}."
    if error["type"] == "value_error":
        return str(error["ctx"]["error"]).rstrip(".") + "."
    if error["type"] == "tuple_type":
        return f"write a list, as [1.0, 2.0] (given: {SHORT.repr(error['input'])})."
    if error["type"] == "union_tag_not_found":
        return "this table needs a `type`."
    return f"{error['msg'][:1].lower()}{error['msg'][1:]} (given: {SHORT.repr(error['input'])})."
