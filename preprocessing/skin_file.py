"""The file skin.toml: everything that preprocessing needs to know about one skin, checked key by key."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, model_validator

from preprocessing.shape_parameters import mode_name
from toolkit.errors import InputError
from toolkit.toml_file import read_toml
from toolkit.units import LARGEST


def _ordinary(value: float) -> float:
    if value and not 1 / LARGEST <= value <= LARGEST:
        raise ValueError(f"numbers from {1 / LARGEST:g} to {LARGEST:g} can be meant; mend the exponent or the units")
    return value


Positive = Annotated[float, Field(gt=0, allow_inf_nan=False), AfterValidator(_ordinary)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False), AfterValidator(_ordinary)]


def _file_name(name: str) -> str:
    if "\0" in name:
        raise ValueError("a file name cannot hold a zero byte; write the path of the file")
    return name


def _interface_name(name: str) -> str:
    """It becomes the name of a group of an HDF5 file, and part of paths in which dots separate."""
    if not name.strip() or set(name) & set("./\0"):
        raise ValueError("this is no legal name of a point; use letters, digits and _")
    return name


FileName = Annotated[str, AfterValidator(_file_name)]
InterfaceName = Annotated[str, AfterValidator(_interface_name)]
ModeName = Annotated[str, AfterValidator(mode_name)]


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Airfoil(_Table):
    """The undeformed and the wanted section, files in one common frame, and the length of their chord."""

    file: FileName  # relative to skin.toml
    target: FileName
    chord: Positive  # length
    units: Literal["chord", "percent", "mm", "m"] | None = None  # of both files, fractions of the chord if not given
    y_scale: Positive = 1.0  # by which the y of both files are multiplied


class ContourPoint(_Table):
    """Where a side of the contour has one x."""

    x: FiniteFloat  # length
    side: Literal["upper", "lower"]


class SkinCut(_Table):
    """The part of the contour that is the skin, from F (start) round the nose to G (end), and its elements."""

    start: ContourPoint
    end: ContourPoint
    elements: Annotated[int, Field(ge=2, le=500)]
    spacing: Literal["equal", "curvature"] = "equal"
    grading: NonNegative = 1.0  # of the curvature spacing: node density 1 + grading sqrt(|curvature| length)
    clamp: Literal["F", "G"] = "F"  # the end that the body's frame is tied to


class ShapeMode(_Table):
    """A smooth bump of the contour along its outward normal: height (1 - q^2)^4 for |q| < 1, q = distance / half_width.

    Its centre is the place where the contour has an x on one side, or an arc length from F; it and the distance from it along the
    contour are those without all bumps. The name of the mode is that of its design variable, the height.
    """

    arc_length: FiniteFloat | None = None  # of the centre, from F; negative ahead of F
    x: FiniteFloat | None = None  # of the centre, with its side; not at the nose, where x says little
    side: Literal["upper", "lower"] | None = None
    half_width: Positive  # length along the contour from the centre to both ends
    height: FiniteFloat = 0.0  # length, positive outward, at most half_width
    of: Literal["airfoil", "target", "both"] = "airfoil"  # which of the files it deforms

    @model_validator(mode="after")
    def _can_be_meant(self) -> ShapeMode:
        given = {key for key in ("arc_length", "x", "side") if getattr(self, key) is not None}
        if given not in ({"arc_length"}, {"x", "side"}):
            raise ValueError(f"give either arc_length, or x with side (got {', '.join(sorted(given)) or 'nothing'})")
        if abs(self.height) > self.half_width:
            raise ValueError(f"a bump of half_width {self.half_width:g} cannot have a height of {self.height:g}; make it wider")
        return self


class SectionTable(_Table):
    """Rectangular section: thickness in the plane of the airfoil, width along the span."""

    thickness: Positive  # length
    width: Positive  # length


class Material(_Table):
    """Linear elastic material. Beams in plane stress do not use Poisson's ratio; it is kept as information."""

    youngs_modulus: Positive  # stress
    density: Positive  # mass / length^3
    poisson_ratio: Annotated[float, Field(gt=-1, lt=0.5)] | None = None


class Damping(_Table):
    """Rayleigh damping D = mass M + stiffness K."""

    mass: NonNegative = 0.0  # 1 / time
    stiffness: NonNegative = 0.0  # time


class Place(_Table):
    """A place on the skin: a node (0 at F), an arc length from F, or an x on one side."""

    node: Annotated[int, Field(ge=0)] | None = None
    arc_length: FiniteFloat | None = None
    x: FiniteFloat | None = None
    side: Literal["upper", "lower"] | None = None

    @model_validator(mode="after")
    def _one_way(self) -> Place:
        given = set(self.where)
        if given not in ({"node"}, {"arc_length"}, {"x", "side"}):
            raise ValueError(f"give either node, or arc_length, or x with side (got {', '.join(sorted(given)) or 'nothing'})")
        return self

    @property
    def where(self) -> dict[str, Any]:
        """The keys that are given, as arguments of `Skin.locate`."""
        return self.model_dump(exclude_none=True)


class SkinFile(_Table):
    """Schema of skin.toml; all numbers in the units of the named system."""

    units: Literal["mm-t-s", "m-kg-s"]
    airfoil: Airfoil
    skin: SkinCut
    section: SectionTable
    material: Material
    damping: Damping = Damping()
    interface_points: dict[InterfaceName, Place] = {}
    shape: dict[ModeName, ShapeMode] = {}


def read_skin_file(path: str | Path) -> SkinFile:
    """Read and check skin.toml.

    Raises
    ------
    InputError
        The file is missing, no TOML, or a key is unknown, missing or has a value that cannot be meant; every such key is named.
    """
    path = Path(path)
    content = read_toml(path, "a skin.toml")
    try:
        return SkinFile.model_validate(content)
    except ValidationError as error:
        problems = "\n".join(f"  {_explain(item)}" for item in error.errors())
        raise InputError(f"{str(path)!r} cannot be used:\n{problems}") from error


def _explain(item: Any) -> str:
    """One line on one wrong key: where it is, what is wrong, what would be right."""
    location = item["loc"][:-2] if item["loc"][-1] == "[key]" else item["loc"]
    key = ".".join(str(part) for part in location)
    if item["type"] == "extra_forbidden":
        return f"{key}: unknown key; allowed here: {', '.join(_keys(location[:-1]))}."
    if item["type"] == "missing":
        return f"{key}: this key is missing; add it."
    reason = item["msg"].removeprefix("Value error, ")
    value = "" if isinstance(item["input"], dict) else f" (got {item['input']!r})"
    return f"{key}: {reason[0].lower()}{reason[1:]}{value}."


def _keys(location: tuple[str | int, ...]) -> list[str]:
    """Keys of the table at a location of the schema."""
    table: Any = SkinFile
    for part in location:
        of_mapping = get_args(table)  # (InterfaceName, Place) of dict
        table = of_mapping[1] if of_mapping else table.model_fields[str(part)].annotation
    return list(table.model_fields)
