"""The tables of frame.toml: what each key is, and what it can be."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat, model_validator

from preprocessing.elements.section_shape import SectionShape, circle, general, rectangle, tube
from preprocessing.recipes.tables import InterfaceName, Positive, Table

Coordinates = Annotated[list[FiniteFloat], Field(min_length=2, max_length=3)]
Triple = Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]
Pair = Annotated[list[FiniteFloat], Field(min_length=2, max_length=2)]
NAMED = InterfaceName
"""Names of nodes, sections and materials become parts of the names of parameters."""

DIMENSIONS: dict[str, dict[str, str]] = {
    "rectangle": {"thickness": "length", "width": "length"},
    "circle": {"diameter": "length"},
    "tube": {"diameter": "length", "wall": "length"},
    "general": {
        "area": "area",
        "I_y": "second_moment",
        "I_z": "second_moment",
        "J": "second_moment",
        "I_p": "second_moment",
    },
}
"""Kind of a section -> its numbers, and what they are, for their units."""
SHEAR_FACTORS = {"rectangle": 5 / 6, "circle": 9 / 10}
"""Kind of a section -> kappa (Reissner); that of a tube depends on its wall, from 0.5 if it is thin."""


class PolarNode(Table):
    """A node of a plane frame at a length and an angle from another one; both are design variables, `length_B` and `angle_B`."""

    start: str = Field(alias="from")  # name of a node
    length: Positive  # length
    angle: FiniteFloat = 0.0  # rad, from the x axis, counter-clockwise


class BeamTable(Table):
    """A straight beam between two nodes, of equal elements."""

    start: str = Field(alias="from")  # name of a node
    end: str = Field(alias="to")
    elements: Annotated[int, Field(ge=1, le=500)] = 4
    section: str  # name of a section
    orientation: Triple | None = (
        None  # in space, direction of the section's third axis, less its part along the beam; by default z, or x of a beam along z
    )


class FrameSection(Table):
    """A section by its dimensions, or by its numbers (`general`), and the material that it is made of.

    The third axis of a section is the orientation of its beam, the second one is perpendicular to that and to the beam: the width of a
    rectangle lies along the third, its thickness along the second: in the plane, where every section is a rectangle, the thickness lies
    in the plane and the width across it. I_y is int y_3^2 dA (bending about the second axis), I_z is
    int y_2^2 dA, J the torsion constant, and I_p the polar moment of the section's mass, I_y + I_z of a homogeneous section.
    """

    kind: Literal["rectangle", "circle", "tube", "general"]
    material: str  # name of a material
    thickness: Positive | None = None  # length; of a rectangle
    width: Positive | None = None  # length; of a rectangle
    diameter: Positive | None = None  # length; of a circle, outer one of a tube
    wall: Positive | None = None  # length; thickness of a tube's wall
    shear_factor: Annotated[float, Field(gt=0, le=1)] | None = (
        None  # kappa, with shear; by default 5/6 of a rectangle, 0.9 of a circle
    )
    area: Positive | None = None  # length^2
    I_y: Positive | None = None  # length^4, as the next three
    I_z: Positive | None = None
    J: Positive | None = None
    I_p: Positive | None = None
    fibres: list[Pair] | None = None  # of a general section: places y_2, y_3 whose stress is told; by default the centre

    @model_validator(mode="after")
    def _can_be_meant(self) -> FrameSection:
        own = set(DIMENSIONS[self.kind])
        given = {name for names in DIMENSIONS.values() for name in names if getattr(self, name) is not None}
        if given != own:
            raise ValueError(
                f"a {self.kind} has the numbers {', '.join(sorted(own))} (given: {', '.join(sorted(given)) or 'none'})"
            )
        if self.fibres is not None and (self.kind != "general" or not self.fibres):
            raise ValueError("fibres are one or more places of a general section; the others have theirs")
        if self.kind == "tube" and 2 * (self.wall or 0) > (self.diameter or 0):
            raise ValueError('the wall of a tube is at most half its diameter; write kind = "circle" for a full one')
        if self.kind == "general" and (self.I_p or 0) < abs((self.I_y or 0) - (self.I_z or 0)):
            raise ValueError(
                "an I_p below |I_y - I_z| belongs to no distribution of mass; I_y + I_z is that of a homogeneous section"
            )
        return self

    @property
    def dimensions(self) -> dict[str, float]:
        """Dimensions of the section by their names."""
        return {name: getattr(self, name) for name in DIMENSIONS[self.kind]}

    @property
    def kappa(self) -> float | None:
        """Shear factor, the part of the area that carries a shear force: as given, or as of full sections."""
        return SHEAR_FACTORS.get(self.kind) if self.shear_factor is None else self.shear_factor

    @property
    def shape(self) -> SectionShape:
        """Polynomials of the section."""
        if self.kind == "rectangle":
            return rectangle(thin=(self.thickness or 0) <= (self.width or 0))
        if self.kind == "general":
            return general(tuple((y, z) for y, z in self.fibres or [[0.0, 0.0]]))
        return circle() if self.kind == "circle" else tube()


class FrameMaterial(Table):
    """Linear elastic, isotropic material; G = E / (2 (1 + nu)) in torsion and shear."""

    youngs_modulus: Positive  # stress
    density: Positive  # mass / length^3
    poisson_ratio: Annotated[float, Field(gt=-1, lt=0.5)] | None = None  # in space, where beams twist, and with shear


class FramePoint(Table):
    """A node where joints and loads may grip."""

    node: str
