"""Tables and numbers that files of every kind have, and what is said about every key that is wrong."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, Literal, TypeVar, get_args

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails

from preprocessing.reduction.basis import BasisChoice
from toolkit.foundation.errors import SHORT, InputError, meant
from toolkit.foundation.files.safe_files import file_name
from toolkit.foundation.files.toml_file import line_of
from toolkit.foundation.units import LARGEST


def _ordinary(value: float) -> float:
    if value and not 1 / LARGEST <= value <= LARGEST:
        raise ValueError(f"numbers from {1 / LARGEST:g} to {LARGEST:g} are valid; fix the exponent or the units")
    return value


Positive = Annotated[float, Field(gt=0, allow_inf_nan=False), AfterValidator(_ordinary)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False), AfterValidator(_ordinary)]


def interface_name(name: str) -> str:
    """Name of an interface point, refused if it cannot be an HDF5 group or part of a path with dots."""
    if not name.strip() or set(name) & set("./\0"):
        raise ValueError("this is no legal name of a point; use letters, digits and _")
    return name


FileName = Annotated[str, AfterValidator(file_name)]
InterfaceName = Annotated[str, AfterValidator(interface_name)]


class InputTable(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Damping(InputTable):
    """Rayleigh damping D = mass M + stiffness K; the first acts on the whole velocity of the body, not on its deformation alone."""

    mass: NonNegative = 0.0  # 1 / time
    stiffness: NonNegative = 0.0  # time


class BasisTable(InputTable):
    """What the elastic coordinates stand for; all nodal coordinates if left out. One of count, frequency, static_error says how many."""

    kind: Literal["full", "eigenmodes", "craig-bampton", "static"] = "full"
    boundary: Literal["clamped", "free"] = "clamped"  # of eigenmodes: held with the body's frame, or free about mean axes
    count: Annotated[int, Field(ge=0)] | None = None  # of eigenmodes
    frequency: Positive | None = None  # all eigenmodes up to this one, in Hz
    static_error: Positive | None = None  # relative error of the displacements under forces at the interface points
    derivative: Literal["differentiated", "frozen"] = "differentiated"  # whether the shapes follow the design
    chord: Annotated[list[InterfaceName], Field(min_length=2, max_length=2)] | None = (
        None  # two interface points that the body's frame goes through, instead of a clamp
    )
    spin_stiffening: bool = False  # whether scenes may ask how a spin of the body's frame stiffens it, by spin_stiffening = true

    @model_validator(mode="after")
    def _can_be_had(self) -> BasisTable:
        try:
            self.choice()
        except InputError as error:
            raise ValueError(str(error)) from error
        return self

    @property
    def parts(self) -> tuple[str, ...]:
        """Parts of a reduced model that exist because they were asked for."""
        return ("spin",) if self.spin_stiffening else ()

    @property
    def richer_parts(self) -> tuple[str, ...]:
        """Parts of a reduced model with a richer basis, of a frozen body of beams."""
        frozen = self.derivative == "frozen" and self.kind != "full"
        return ("richer_invariants", "richer_derivatives", "richer_affine", "richer_interfaces") if frozen else ()

    def choice(self) -> BasisChoice:
        """Basis choice of the table, as the reduction wants it."""
        return BasisChoice(**{**self.model_dump(), "chord": None if self.chord is None else tuple(self.chord)})

    def complaint(self, what: str, clamped: bool, clamp: str, points: Collection[str]) -> str:
        """Complaint about the place of the body's frame; empty if nothing is wrong.

        Parameters
        ----------
        what : of the body, and whether it is `clamped` by the key `clamp`
        points : names of its interface points
        """
        if self.boundary == "free" and clamped:
            return f'{what} with boundary = "free" floats about mean axes; leave {clamp} out'
        if self.chord is not None and clamped:
            return f"basis.chord: {what} has its frame either on a chord or at a clamp; leave {clamp} or the chord out"
        if unknown := [name for name in self.chord or [] if name not in points]:
            return f"basis.chord: there is no interface point {unknown[0]!r}; there are {', '.join(points) or 'none'}"
        if self.boundary != "free" and self.chord is None and not clamped:
            return (
                f'the body\'s frame needs a place; add {clamp}, or chord = [...] with two interface points, or kind = "eigenmodes" with '
                'boundary = "free", in [basis]'
            )
        return ""


File = TypeVar("File", bound=BaseModel)
Keys = tuple[str | int, ...]
"""Keys of tables and numbers in lists that lead to a value in a file."""


def validated(schema: type[File], content: Mapping[str, object], whose: str, source: Path | None = None) -> File:
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


def put(content: dict[str, object], keys: Sequence[str | int], value: object) -> None:
    """Set a table (`basis`), a key in one (`skin`, `elements`), or an item of a list there (`nodes`, `A`, 0)."""
    *tables, last = keys
    table: Any = content
    for name in tables:
        table = table.setdefault(name, {})
    table[last] = value


def explain(item: ErrorDetails, schema: type[BaseModel]) -> str:
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


def _location(item: ErrorDetails) -> tuple[str | int, ...]:
    """Keys that lead to what is wrong, without pydantic's mark for a key itself."""
    return item["loc"][:-2] if item["loc"][-1:] == ("[key]",) else item["loc"]


def _line(text: str, item: ErrorDetails) -> str:
    """Line number of a wrong key, to append; empty where the file has none."""
    line = line_of(text, ".".join(map(str, _location(item))))
    return "" if line is None else f" (line {line})"


def _keys(schema: type[BaseModel], location: tuple[str | int, ...]) -> list[str]:
    """Keys of the table at a location of the schema."""
    table: Any = schema
    for part in location:
        of_group = get_args(table)  # (InterfaceName, Place) of dict, (BeamTable,) of list
        table = of_group[-1] if of_group else table.model_fields[str(part)].annotation
        options = get_args(table)  # (Table, None) of a key that may be left out
        table = options[0] if options[1:] == (NoneType,) else table
    return [field.alias or name for name, field in table.model_fields.items()]
