"""The file skin.toml: everything that preprocessing needs to know about one skin, checked key by key."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import NoneType
from typing import Any, Literal, TypeVar, get_args

from pydantic import BaseModel, Field, ValidationError, model_validator

from preprocessing.recipes.skin.skin_tables import (
    Airfoil,
    BasisTable,
    Damping,
    ElementGroup,
    GroupName,
    InterfaceName,
    Material,
    ModeName,
    Place,
    SectionTable,
    ShapeMode,
    SkinCut,
    Table,
)
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.toml_file import read_toml

File = TypeVar("File", bound=BaseModel)


class SkinFile(Table):
    """Schema of skin.toml; all numbers in the units of the named system."""

    units: Literal["mm-t-s", "m-kg-s"]
    dimension: Literal[2, 3] = 2  # of space; 3: the skin also bends out of its plane and twists, which needs Poisson's ratio
    airfoil: Airfoil
    skin: SkinCut
    section: SectionTable
    material: Material
    damping: Damping = Damping()
    interface_points: dict[InterfaceName, Place] = Field(default_factory=dict)
    shape: dict[ModeName, ShapeMode] = Field(default_factory=dict)
    groups: dict[GroupName, ElementGroup] = Field(default_factory=dict)
    basis: BasisTable = BasisTable()

    @model_validator(mode="after")
    def _twists(self) -> SkinFile:
        if self.dimension == 3 and self.material.poisson_ratio is None:
            raise ValueError("material.poisson_ratio: a skin in space (dimension = 3) twists with G = E / (2 (1 + nu)); add it")
        return self


def read_skin_file(path: str | Path) -> SkinFile:
    """Read and check skin.toml.

    Raises
    ------
    InputError
        The file is missing, no TOML, or a key is unknown, missing or has a value that cannot be meant; every such key is named.
    """
    path = Path(path)
    content = read_toml(path, "a skin.toml")
    return validated(SkinFile, content, path)


def validated(schema: type[File], content: Mapping[str, Any], path: str | Path) -> File:
    """The content of the file at `path`, checked against its schema.

    Raises
    ------
    InputError
        Names every key that is unknown, missing or has a value that cannot be meant.
    """
    try:
        return schema.model_validate(content)
    except ValidationError as error:
        problems = "\n".join(f"  {explain(item, schema)}" for item in error.errors())
        raise InputError(f"{str(path)!r} cannot be used:\n{problems}") from error


def explain(item: Any, schema: type[BaseModel] | None = None) -> str:
    """One line on one wrong key: where it is, what is wrong, what would be right.

    Parameters
    ----------
    schema : that of the file, skin.toml by default
    """
    location = item["loc"][:-2] if item["loc"][-1:] == ("[key]",) else item["loc"]
    key = ".".join(str(part) for part in location)
    if item["type"] == "extra_forbidden":
        return f"{key}: unknown key; allowed here: {', '.join(_keys(schema or SkinFile, location[:-1]))}."
    if item["type"] == "missing":
        return f"{key}: this key is missing; add it."
    reason = item["msg"].removeprefix("Value error, ")
    value = "" if isinstance(item["input"], dict) else f" (got {item['input']!r})"
    return f"{key}: {reason[0].lower()}{reason[1:]}{value}.".removeprefix(": ")


def _keys(schema: type[BaseModel], location: tuple[str | int, ...]) -> list[str]:
    """Keys of the table at a location of the schema."""
    table: Any = schema
    for part in location:
        of_group = get_args(table)  # (InterfaceName, Place) of dict, (BeamTable,) of list
        table = of_group[-1] if of_group else _optional(table.model_fields[str(part)].annotation)
    return [field.alias or name for name, field in table.model_fields.items()]


def _optional(annotation: Any) -> Any:
    """The type of a key, without the None of one that may be left out."""
    options = get_args(annotation)
    return options[0] if options[1:] == (NoneType,) else annotation
