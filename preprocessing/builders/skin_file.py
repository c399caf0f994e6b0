"""The file skin.toml: its tables, checked key by key, and the design variables of the skin's shape."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, FiniteFloat, model_validator

from preprocessing.builders.tables import (
    BasisTable,
    Damping,
    FileName,
    InputTable,
    InterfaceName,
    NonNegative,
    Positive,
    interface_name,
)

TAKEN = (
    "youngs_modulus", "density", "thickness", "width", "poisson_ratio", "damping_mass", "damping_stiffness", "chord", "y_scale",
    "type", "model", "frame", "position", "angle", "velocity", "angular_velocity", "extrapolation",
)  # fmt: skip
"""Names of the other parameters that a reduced model can have, and keys of a flexible body in a scene."""

TAKEN_PREFIXES = ("thickness_", "width_", "youngs_modulus_", "density_", "damping_mass_", "damping_stiffness_", "arc_length_")
"""Beginnings of the names of parameters of element groups and interface points."""


def mode_name(name: str) -> str:
    """The name itself; it becomes that of a parameter, of a group in an HDF5 file, and part of paths in which dots separate.

    Raises
    ------
    ValueError
        It cannot be one of these, or is that of another parameter.
    """
    if not name.strip() or set(name) & set("./\0"):
        raise ValueError("this is no legal name of a shape mode; use letters, digits and _")
    if name in TAKEN:
        raise ValueError(f"a shape mode cannot have the name of another parameter ({', '.join(TAKEN)}); choose another name")
    if name.startswith(TAKEN_PREFIXES):
        raise ValueError(
            f"a shape mode's name cannot begin like those of element groups ({', '.join(TAKEN_PREFIXES)}); choose another name"
        )
    return name


def _group_name(name: str) -> str:
    """Name of a group, refused if it is no legal part of parameter names, as numbers of single elements are."""
    if name.isdecimal():
        raise ValueError("numbers are for single elements; use a name with a letter")
    return interface_name(name)


GroupName = Annotated[str, AfterValidator(_group_name)]
ElementNumber = Annotated[int, Field(ge=0)]
Quantity = Literal["youngs_modulus", "density", "thickness", "width", "damping_mass", "damping_stiffness"]
ModeName = Annotated[str, AfterValidator(mode_name)]
AirfoilUnits = Literal["chord", "percent", "mm", "m"]


class AirfoilTable(InputTable):
    """The undeformed and the wanted section, files in one common frame, and the length of their chord."""

    file: FileName  # relative to skin.toml
    target: FileName
    chord: Positive  # length
    units: AirfoilUnits | None = None  # of both files, fractions of the chord if not given
    target_units: AirfoilUnits | None = None  # of the target, if they are not those of the file
    y_scale: Positive = 1.0  # by which the y of both files are multiplied

    @property
    def in_lengths(self) -> list[str]:
        """Units of length that one of the files is in, which no chord scales."""
        return [each for each in dict.fromkeys((self.units, self.target_units)) if each in ("mm", "m")]


MOST_ELEMENTS, MOST_REDUCED = 2000, 500
"""Of a skin in the plane with all coordinates, whose arrays are zero nearly everywhere, but are made and checked whole: with so many that
takes 5 GB of memory. And of any other skin: in space there are six arrays with the square of twice as many coordinates, and modes are
those of dense matrices, with the third power."""


class ContourPoint(InputTable):
    """Where a side of the contour has one x."""

    x: FiniteFloat  # length
    side: Literal["upper", "lower"]


class SkinCut(InputTable):
    """The part of the contour that is the skin, from F (start) round the nose to G (end), and its elements."""

    start: ContourPoint
    end: ContourPoint
    elements: Annotated[int, Field(ge=2, le=MOST_ELEMENTS)]
    spacing: Literal["equal", "curvature"] = "equal"
    grading: NonNegative = 1.0  # of the curvature spacing: node density 1 + grading sqrt(|curvature| length)
    clamp: Literal["F", "G"] | None = None  # the end that the body's frame is tied to, F if not given
    separate: list[Quantity] = Field([])  # what every element has of its own: thickness_0 is that of the first element, and so on


class ShapeMode(InputTable):
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
            raise ValueError(f"give either arc_length, or x with side (given: {', '.join(sorted(given)) or 'nothing'})")
        if abs(self.height) > self.half_width:
            raise ValueError(f"a bump of half_width {self.half_width:g} cannot have a height of {self.height:g}; make it wider")
        return self


class SectionTable(InputTable):
    """Rectangular section: thickness in the plane of the airfoil, width along the span."""

    thickness: Positive  # length
    width: Positive  # length


class Material(InputTable):
    """Linear elastic material.

    Poisson's ratio enters in plane strain, where a wide skin bends with E / (1 - nu^2) instead of E, and in space, where a skin twists with
    G = E / (2 (1 + nu)).
    """

    youngs_modulus: Positive  # stress
    density: Positive  # mass / length^3
    poisson_ratio: Annotated[float, Field(gt=-1, lt=0.5)] | None = None
    state: Literal["plane-stress", "plane-strain"] = "plane-stress"  # narrow, or kept from contracting along the span

    @model_validator(mode="after")
    def _ratio_given(self) -> Material:
        if self.state == "plane-strain" and self.poisson_ratio is None:
            raise ValueError("plane strain depends on Poisson's ratio; add poisson_ratio")
        return self


class ElementGroup(InputTable):
    """Elements that have quantities of their own; each becomes a design variable, for example `thickness_nose` of a group `nose`."""

    elements: Annotated[list[ElementNumber], Field(min_length=2, max_length=2)]  # the first and the last one, counted from 0 at F
    youngs_modulus: Positive | None = None  # stress
    density: Positive | None = None  # mass / length^3
    thickness: Positive | None = None  # length
    width: Positive | None = None  # length
    damping_mass: NonNegative | None = None  # 1 / time
    damping_stiffness: NonNegative | None = None  # time

    @model_validator(mode="after")
    def _has_values(self) -> ElementGroup:
        if not self.values:
            raise ValueError("a group needs a quantity of its own, for example thickness")
        return self

    @property
    def values(self) -> dict[str, float]:
        """The quantities that are given."""
        return self.model_dump(exclude={"elements"}, exclude_none=True)


class Place(InputTable):
    """A place on the skin: a node (0 at F), an arc length from F, or an x on one side."""

    node: Annotated[int, Field(ge=0)] | None = None
    arc_length: FiniteFloat | None = None
    x: FiniteFloat | None = None
    side: Literal["upper", "lower"] | None = None

    @model_validator(mode="after")
    def _one_way(self) -> Place:
        given = {*self.model_dump(exclude_none=True)}
        if given not in ({"node"}, {"arc_length"}, {"x", "side"}):
            raise ValueError(f"give either node, or arc_length, or x with side (given: {', '.join(sorted(given)) or 'nothing'})")
        return self


class SkinFile(InputTable):
    """Schema of skin.toml; all numbers in the units of the named system."""

    units: Literal["mm-t-s", "m-kg-s"]
    dimension: Literal[2, 3] = 2  # of space; 3: the skin also bends out of its plane and twists, which needs Poisson's ratio
    rotary_inertia: bool = True  # of the section's bending in the plane; false: its mass lies on the middle line
    airfoil: AirfoilTable
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

    @model_validator(mode="after")
    def _is_small_enough(self) -> SkinFile:
        whole = self.dimension == 2 and self.basis.kind == "full" and self.basis.chord is None
        if self.skin.elements > MOST_REDUCED and not whole:
            raise ValueError(
                f"skin.elements: {self.skin.elements} are more than {MOST_REDUCED}, the most of a skin in space, on a chord or with fewer "
                'coordinates, whose matrices are dense; take fewer, or in the plane all coordinates (kind = "full"), '
                f"of up to {MOST_ELEMENTS} elements"
            )
        return self

    @model_validator(mode="after")
    def _has_one_frame(self) -> SkinFile:
        other = self.basis.chord is not None or self.basis.boundary == "free"
        clamped = self.skin.clamp is not None or not other
        if self.basis.boundary != "free" and (
            complaint := self.basis.complaint("a skin", clamped, "skin.clamp", self.interface_points)
        ):
            raise ValueError(complaint)
        return self

    @property
    def clamp(self) -> Literal["F", "G"]:
        """End of the skin that the frame is tied to, if it is tied to one."""
        return self.skin.clamp or "F"


def shape_parameters(file: SkinFile) -> dict[str, float]:
    """Nominal values by name, the modes in the order of the file.

    Airfoil files in mm or m hold lengths, which the chord only checks: nothing depends on it, and it is left out.
    """
    chord = {} if file.airfoil.in_lengths else {"chord": float(file.airfoil.chord)}
    modes = {name: float(mode.height) for name, mode in file.shape.items()}
    return {**chord, "y_scale": float(file.airfoil.y_scale), **modes}
