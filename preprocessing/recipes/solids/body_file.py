"""The file body.toml: a flexible body made of a mesh or of finished matrices, checked key by key."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from preprocessing.recipes.solids.body_tables import (
    MatricesTable,
    MeshTable,
    PiecesTable,
    Region,
    ShapeVariable,
    SolidMaterial,
    SolidSection,
    StressTable,
    TiedRegion,
)
from preprocessing.recipes.tables import BasisTable, Damping, InterfaceName, Table


class BodyFile(Table):
    """Schema of body.toml; all numbers in the units of the named system.

    It has a mesh, or finished matrices, or both: then the mesh gives the nodes, their groups and the stress.
    """

    units: Literal["mm-t-s", "m-kg-s"]
    mesh: MeshTable | None = None
    matrices: MatricesTable | None = None
    material: SolidMaterial | None = None
    section: SolidSection | None = None
    damping: Damping = Damping()
    clamp: Region | None = None  # the nodes that the body's frame is tied to
    interface_points: dict[InterfaceName, TiedRegion] = Field(default_factory=dict)
    pressure_surfaces: dict[InterfaceName, Region] = Field(
        default_factory=dict
    )  # of spatial bodies, for pressures on their faces
    shape_variables: dict[InterfaceName, ShapeVariable] = Field(default_factory=dict)
    pieces: PiecesTable | None = None  # of spatial bodies, for several floating frames
    basis: BasisTable = BasisTable()
    stress: StressTable = StressTable()

    @model_validator(mode="after")
    def _can_be_meant(self) -> BodyFile:
        for complaint in (self._lacking(), self._frame(), self._cut()):
            if complaint:
                raise ValueError(complaint)
        return self

    def _lacking(self) -> str:
        if self.mesh is None and self.matrices is None:
            return "a body needs [mesh], or [matrices]; add one of them"
        if self.material is None and self.section is not None:
            return "[section] belongs to [material]; add the latter"
        if self.matrices is None and (self.material is None or self.material.poisson_ratio is None):
            return "elements need [material] with youngs_modulus, poisson_ratio and density; add what lacks"
        if self.mesh is None and self.matrices is not None and self.matrices.nodes is None:
            return "finished matrices need the places of their nodes; add matrices.nodes, or [mesh]"
        if self.matrices is not None and self.matrices.mass_differs and self.material is None:
            return "matrices.mass_differs is about the density of [material]; without [material] leave it out"
        if self.mesh is None and self.pressure_surfaces:
            return "[pressure_surfaces] are faces of elements; add [mesh]"
        if self.matrices is not None and self.shape_variables:
            return "[shape_variables] move the nodes of elements, but finished matrices stay as they are; leave one of them out"
        return ""

    def _frame(self) -> str:
        return self.basis.complaint("a body", self.clamp is not None, "[clamp]", self.interface_points)

    def _cut(self) -> str:
        if self.pieces is None:
            return ""
        if self.matrices is not None:
            return "[pieces] are those of a mesh without [matrices]; leave one of them out"
        if self.clamp is None:
            return (
                "[pieces] begin at a clamp, to which the frame of the whole body is tied; add [clamp] with the nodes at one end"
            )
        if self.basis != BasisTable():
            return "[pieces] keep all motions of their ends and nothing else, which no [basis] can change; leave one of them out"
        if not self.interface_points:
            return "[pieces] end at an interface point; add one with the nodes at the end that is not clamped"
        return ""

    @property
    def inputs(self) -> list[str]:
        """Names of all other files that the body is made of."""
        matrices = self.matrices
        named = [self.mesh.file if self.mesh else None]
        named += [variable.field for variable in self.shape_variables.values()]
        if matrices is not None:
            named += [matrices.mass, matrices.stiffness, matrices.nodes, matrices.stress]
            named += dict.fromkeys(matrices.degrees_of(name) for name in (matrices.mass, matrices.stiffness))
        return [name for name in named if name is not None]
