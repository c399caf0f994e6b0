"""Base of all that a person writes: frozen, validated records whose numbers can be reached by a path."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import file_name
from toolkit.foundation.units import LABELLED, LARGEST, NONE, SMALLEST, Dimension
from toolkit.foundation.value_types import Scalar as Scalar

if TYPE_CHECKING:
    from pydantic import GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

if TYPE_CHECKING:
    from pydantic import GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core.core_schema import CoreSchema

ANGLE = "angle"
"""The one word without dimension that has a unit nevertheless."""


class Measure(NamedTuple):
    """Measure of one number: its dimension, and the power of an angle, which has a unit but no dimension."""

    dimension: Dimension
    angle: int = 0


class Quantity:
    """Measure of the numbers of a field: of all of them in one, or of each in its order.

    Words are those of `toolkit.foundation.units.LABELLED`; factors stand apart by spaces, a slash divides by what follows it:
    "mass", "mass length^2", "length/time^2", "1/time", "none". Conversion of units, labels of gradients, schema and documentation read it.

    Parameters
    ----------
    each : one text for all numbers of the field, or one for each; none at all for what the owner of the record says of it

    Raises
    ------
    InputError
        A word names no quantity; lists those that do.
    """

    def __init__(self, *each: str) -> None:
        self.each = each
        self._measures = [_measure(text) for text in each]

    @property
    def of_owner(self) -> bool:
        """Whether the measure is said where the record stands, as that of the values of a time curve is."""
        return not self.each

    def measure_of(self, values: Measure, place: int = 0) -> Measure:
        """Measure of the number at a place of a field; `values` is what the owner of the record says that its values measure."""
        return values if self.of_owner else self.measure(place)

    def measure(self, place: int = 0) -> Measure:
        """Measure of the number at a place of a list, or of all numbers where one text stands for all."""
        return self._measures[place if len(self._measures) > 1 else 0]

    def __get_pydantic_json_schema__(self, core_schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """JSON schema of the field with its measure in words, for those who write a file."""
        schema = handler(core_schema)
        if any(text != "none" for text in self.each) and "$ref" not in schema:
            schema["description"] = ", ".join(self.each)
        return schema


class PerTime(Quantity):
    """Coefficients of a polynomial of time: what its values measure, per time to the power of the place."""

    def measure_of(self, values: Measure, place: int = 0) -> Measure:
        """Measure of the coefficient at a place: `values` per time to the power of the place.

        The first coefficient is a value itself.
        """
        return Measure(values.dimension.times(LABELLED["time"].power(-place)), values.angle)


class OverAngle(Quantity):
    """Values of a curve whose argument is an angle where others have their time."""


OF_OWNER = Quantity()
"""Measure of a value of a time curve, which is said where the curve stands."""
OF_OWNER_PER_TIME = PerTime()
"""Measure of coefficients of a polynomial of time, which is said where the curve stands."""


def _measure(text: str) -> Measure:
    """Measure that a text such as "force time/length" stands for."""
    found, angle = NONE, 0
    for k, factors in enumerate(text.split("/")):
        for word in factors.split():
            name, _, power = word.partition("^")
            exponent = int(power or 1) * (-1 if k else 1)
            if name not in LABELLED and name != "1":
                raise InputError(
                    f"{text!r} names no quantity; its words are {', '.join(LABELLED)}, with powers such as length^2."
                )
            found = found.times(LABELLED.get(name, NONE).power(exponent))
            angle += exponent * (name == ANGLE)
    return Measure(found, angle)


def import_room(name: str) -> None:
    """Import every module of a room and of those inside it, by name, so that every kind defined there can be named in a scene file.

    Rooms of compiled formulas, `kernels`, hold no kinds and are left alone.

    Parameters
    ----------
    name
        The room's dotted name, such as "toolkit.components.joints".
    """
    for found in iter_modules(import_module(name).__path__, f"{name}."):
        if not found.ispkg:
            import_module(found.name)
        elif not found.name.endswith(".kernels"):
            import_room(found.name)


def _ordinary(value: float) -> float:
    if value and not SMALLEST <= abs(value) <= LARGEST:
        raise ValueError(
            f"{value:g} is invalid: numbers are zero or from {SMALLEST:g} to {LARGEST:g}; fix the exponent or the units"
        )
    return value


_NUMBER: dict[str, Any] = {"strict": True, "allow_inf_nan": False}
Number = Annotated[float, Field(**_NUMBER), AfterValidator(_ordinary)]
"""A finite number of a size that a unit system can bring about; no text and no truth value passes for one."""
Positive = Annotated[float, Field(gt=0, **_NUMBER), AfterValidator(_ordinary)]
NotNegative = Annotated[float, Field(ge=0, **_NUMBER), AfterValidator(_ordinary)]
FileName = Annotated[str, AfterValidator(file_name)]
"""Name or path of a file that somebody wrote."""
Pair = tuple[Number, Number]
Triple = tuple[Number, Number, Number]


class Description(BaseModel):
    """Base of all descriptions: frozen, no unknown keys, no numbers that are not finite.

    `with_number` replaces one number without validating again, so that it may be complex: the complex step through
    the construction formulas relies on it. What a field's numbers measure stands beside it: `Annotated[Positive, Quantity("mass")]`.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    @classmethod
    def __pydantic_init_subclass__(cls, **_: object) -> None:
        """Note that facts of a kind are facts: pydantic would evaluate the texts of their types for every kind that is derived from it."""
        own: dict[str, Any] = vars(cls).get("__annotations__", {})
        own.update(dict.fromkeys(own.keys() & cls.__class_vars__, ClassVar))

    def numbers(self) -> Iterator[tuple[str, float | complex]]:
        """Paths and values of all numbers below this record."""
        for name, value in self:
            if self.means(name):
                yield from numbers_below(name, value)

    def means(self, _field: str) -> bool:
        """Whether the numbers of a field mean something, as all do unless another field says otherwise."""
        return True

    def quantity_of(self, field: str) -> Quantity | None:
        """Measure of a field's numbers, as it stands beside the field; None if nobody has said it."""
        described = (kind.model_fields.get(field) for kind in type(self).__mro__ if issubclass(kind, Description))
        facts = (each for info in described if info is not None for each in info.metadata)
        return next((each for each in facts if isinstance(each, Quantity)), None)

    def with_number(self, path: str, value: float | complex) -> Self:
        """A copy in which the number at the path has another value, real or complex.

        Raises
        ------
        InputError
            The path leads nowhere, or to what is not a number.
        """
        return self.with_all({path: value})

    def with_all(self, values: Mapping[str, float | complex]) -> Self:
        """A copy in which the numbers at several paths, at least one, have other values."""
        found = _replace(self, [(path.split("."), value, path) for path, value in values.items()])
        assert isinstance(found, type(self))
        return found


class Registered(Description):
    """Base of open sets of descriptions: every subclass with a `kind` can be named in a scene file.

    `kinds` of a base lists all that were defined below it and belong to the same space as the base itself, so that components in space
    may have the names of those in the plane.
    """

    kind: ClassVar[str] = ""
    dimension: ClassVar[int] = 0
    """Dimension of the space that it belongs to; 0 of what belongs to none, as every neutral base."""
    kinds: ClassVar[dict[str, type[Registered]]] = {}

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: object) -> None:
        super().__pydantic_init_subclass__(**kwargs)
        if not cls.kind:
            cls.kinds = {}
        for base in cls.__mro__:
            if cls.kind and "kinds" in vars(base) and issubclass(base, Registered) and base.dimension == cls.dimension:
                vars(base)["kinds"][cls.kind] = cls


class InSpace(Registered):
    """Base of what belongs to the plane or to space: a neutral base promises nothing of either, and no kind is neutral."""

    siblings: ClassVar[str] = ""
    """Bases of the plane and of space that a new kind is derived from."""

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: object) -> None:
        if cls.kind and not cls.dimension:
            raise TypeError(f"{cls.__name__} belongs neither to the plane nor to space: derive it from {cls.siblings}.")
        super().__pydantic_init_subclass__(**kwargs)


def numbers_below(path: str, value: object) -> Iterator[tuple[str, float | complex]]:
    """Paths and values of all numbers below a value that sits at `path`."""
    if isinstance(value, (float, complex)):
        yield path, value
    elif isinstance(value, Description):
        for name, below in value.numbers():
            yield f"{path}.{name}", below
    elif isinstance(value, Mapping):
        for name, below in value.items():
            yield from numbers_below(f"{path}.{name}", below)
    elif isinstance(value, (tuple, list)):
        for index, below in enumerate(value):
            yield from numbers_below(f"{path}.{_AXES[index] if _is_pair(value) else index}", below)


def holds_complex(value: object) -> bool:
    """Whether any number below a value is complex."""
    if isinstance(value, Description):
        return any(holds_complex(below) for _, below in value)
    if isinstance(value, Mapping):
        return any(map(holds_complex, value.values()))
    return any(map(holds_complex, value)) if isinstance(value, (tuple, list)) else isinstance(value, complex)


def number_at(value: object, keys: Sequence[str]) -> float | complex | None:
    """Number that keys lead to from a value, as `numbers_below` names it; None if there is none."""
    for key in keys:
        if isinstance(value, Description):
            extra = value.model_extra or {}
            value = (extra[key] if key in extra else value.__dict__.get(key)) if value.means(key) else None
        elif isinstance(value, Mapping):
            value = value.get(key)
        elif isinstance(value, (tuple, list)):
            names = _AXES if _is_pair(value) else [str(index) for index in range(len(value))]
            value = value[names.index(key)] if key in names else None
        else:
            return None
    return value if isinstance(value, (float, complex)) else None


_AXES = ("x", "y")


def _is_pair(value: Sequence[object]) -> bool:
    return len(value) == 2 and all(isinstance(item, (float, complex)) for item in value)


def _replace(owner: object, changes: Sequence[tuple[list[str], float | complex, str]]) -> object:
    """A copy with other numbers: the keys that lead to each from here, its value, and its whole path for messages."""
    keys, value, path = changes[0]
    if not keys:
        if not isinstance(owner, (float, complex)):
            raise InputError(f"{path!r} is not a number of the scene, but {owner!r}. Give the path of a number.")
        return value
    items: dict[str, object] = {}
    if isinstance(owner, Description | Mapping):
        items = dict(owner)
    elif isinstance(owner, tuple):
        items = {_AXES[i] if _is_pair(owner) else str(i): item for i, item in enumerate(owner)}
    below: dict[str, list[tuple[list[str], float | complex, str]]] = {}
    for (key, *rest), value, path in changes:
        if key not in items:
            raise InputError(f"{path!r} leads nowhere: there is no {key!r}; possible here: {', '.join(items) or 'nothing'}.")
        below.setdefault(key, []).append((rest, value, path))
    found = {key: _replace(items[key], some) for key, some in below.items()}
    if isinstance(owner, Description):
        return owner.model_copy(update=found)
    return tuple({**items, **found}.values()) if isinstance(owner, tuple) else {**items, **found}
