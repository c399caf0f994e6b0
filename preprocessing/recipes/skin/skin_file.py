"""The file skin.toml: everything that preprocessing needs to know about one skin, checked key by key."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from preprocessing.recipes.skin.skin_tables import (
    MOST_ELEMENTS,
    MOST_REDUCED,
    Airfoil,
    ElementGroup,
    GroupName,
    Material,
    ModeName,
    Place,
    SectionTable,
    ShapeMode,
    SkinCut,
)
from preprocessing.recipes.tables import BasisTable, Damping, InterfaceName, Table


class SkinFile(Table):
    """Schema of skin.toml; all numbers in the units of the named system."""

    units: Literal["mm-t-s", "m-kg-s"]
    dimension: Literal[2, 3] = 2  # of space; 3: the skin also bends out of its plane and twists, which needs Poisson's ratio
    rotary_inertia: bool = True  # of the section's bending in the plane; false: its mass lies on the middle line
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
