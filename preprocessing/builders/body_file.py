"""The file body.toml: a flexible body made of a mesh or of finished matrices, checked key by key."""

from __future__ import annotations

from pathlib import PurePath
from typing import Annotated, Literal

from pydantic import Field, FiniteFloat, model_validator

from preprocessing.builders.tables import BasisTable, Damping, FileName, InputTable, InterfaceName, Positive

NodeNumber = Annotated[int, Field(ge=0)]
Coordinates = Annotated[list[FiniteFloat], Field(min_length=2, max_length=3)]
Box = Annotated[list[FiniteFloat], Field(min_length=4, max_length=6)]


OF_CALCULIX = (".sti", ".mas")
"""Endings of the matrices of CalculiX, whose rows a file of the same name and with the ending .dof explains."""


class MeshTable(InputTable):
    """A mesh: gmsh (.msh), Abaqus and CalculiX (.inp), Nastran (.bdf, .nas, .fem), VTK (.vtk, .vtu), MED, UNV, Ansys (.cdb), and others.

    The page "From your FE program" tells what of them is read. Its tetrahedra (4 or 10 nodes), hexahedra (8, 20 or 27) and wedges (6 or 15)
    are the body. Without any the body is plane, of triangles (3 or 6 nodes) and quadrilaterals (4, 8 or 9). Elements of lower dimension
    serve to name groups.
    """

    file: FileName  # relative to body.toml
    scale: Positive = 1.0  # by which its coordinates are multiplied, for example 0.001 from mm to m
    leave_out: list[str] = Field(default_factory=list)  # element types, keywords, cards that are not part of the body: "S4R"


class MatricesTable(InputTable):
    """Finished matrices of displacement-based finite elements, free of supports: x and y of node 0, x and y of node 1, and so on.

    In space they have x, y and z of every node. Matrix Market (.mtx), the text of Abaqus' MATRIX OUTPUT (.mtx, in any of its formats), the
    .sti and .mas of CalculiX with their .dof, or SciPy (.npz). The texts of Abaqus and CalculiX may hold either triangle or both, and the
    node numbers in them are those of the mesh file; a matrix in Matrix Market holds one triangle if its first line says symmetric.
    Beside a mesh, [material] is compared with the matrices: their mass with density times volume, their stiffness under uniform strains.
    """

    mass: FileName  # relative to body.toml
    stiffness: FileName  # relative to body.toml, as the others
    nodes: FileName | None = (
        None  # x, y (and z) of one node per line (.csv), or such an array (.npy, .npz); else those of the mesh
    )
    dof: FileName | None = (
        None  # which node and direction each row of CalculiX's .sti and .mas is; by default the .dof of the same name
    )
    mass_differs: bool = (
        False  # true: the mass is not density times volume, for example because of point masses; it has a scale instead
    )
    stress: FileName | None = None  # stress per nodal displacement, one row (in space six) for each stress point; needs no mesh

    def degrees_of(self, name: str) -> str | None:
        """Name of the file that says what the rows of a matrix file are, if it needs one."""
        if self.dof is not None:
            return self.dof
        return str(PurePath(name).with_suffix(".dof")) if PurePath(name).suffix.lower() in OF_CALCULIX else None


class Region(InputTable):
    """Some nodes: those of a group of the mesh, those in a box, or by their numbers."""

    group: str | None = None  # physical group, node set or element set of the mesh file
    box: Box | None = None  # x_min, y_min, x_max, y_max, in space x_min, y_min, z_min, x_max, ...; nodes on its edge are in it
    nodes: Annotated[list[NodeNumber], Field(min_length=1)] | None = None  # counted from 0 in the order of the file

    @model_validator(mode="after")
    def _one_way(self) -> Region:
        given = [key for key in ("group", "box", "nodes") if getattr(self, key) is not None]
        if len(given) != 1:
            raise ValueError(f"give exactly one of group, box, nodes (given: {', '.join(given) or 'none'})")
        return self

    @property
    def words(self) -> str:
        """Words for the region in messages."""
        if self.group is not None:
            return f"group {self.group!r}"
        return f"box {self.box}" if self.box is not None else f"nodes {self.nodes}"


class TiedRegion(Region):
    """Nodes that carry a point with a position and a rotation, where joints and loads may grip.

    `rigid`: the nodes move as one rigid body with the point (RBE2). `averaged`: the point moves with the mean of the nodes, which stay
    free to deform (RBE3). A single node is averaged; its rotation is that of the nodes of the elements around it. Means are those over the
    volume of whole elements, if the nodes are those of such; else over the area (in the plane the length) of the boundary's faces between
    the nodes, if all nodes are on such faces; else over the nodes. So is the place of the point, unless `at` gives it.
    """

    tie: Literal["averaged", "rigid"] = "averaged"
    at: Coordinates | None = None  # the point's undeformed place; by default the mean of the nodes as above


class PiecesTable(InputTable):
    """Groups of elements that the body is cut into, one behind the other from the clamp on: then `frames` of a scene gives it as many
    floating frames as there are pieces, or fewer.

    Two pieces meet in one face, which moves as its middle does and turns: `averaged`, as the mean of its nodes, which each piece deforms
    as if alone, so that the body is too soft by what the faces part; or `rigid`, so that it is too stiff. Each piece has the shapes that
    its two ends give it at rest and no others; so interface points lie on faces between pieces or at an end of the body.
    """

    groups: Annotated[list[str], Field(min_length=1)]  # physical groups or element sets of the mesh file, in any order
    faces: Literal["averaged", "rigid"] = "averaged"  # how the pieces are joined


class SolidSection(InputTable):
    """What stands across the plane."""

    width: Positive  # length


class SolidMaterial(InputTable):
    """Linear elastic, isotropic material. With finished matrices these are the values that they were made with."""

    youngs_modulus: Positive  # stress
    density: Positive  # mass / length^3
    poisson_ratio: Annotated[float, Field(gt=-1, lt=0.5)] | None = None  # elements need it
    state: Literal["plane-stress", "plane-strain"] | None = None  # plane bodies: thin (default), or kept from contracting across


class StressTable(InputTable):
    """What the stress operator gives, linear in the displacements.

    Of plane bodies it is one number for each stress point. `tangential`, the default, is the stress along the boundary in the middle of
    every edge of it, in the order of `outline/edges` of the reduced model: the only one that a free boundary has. `xx`, `yy` and `xy` are
    components in the body's axes in the middle of every element. Of spatial bodies it is `surface`, the default: all six components at the
    nodes of the surface, each the mean of the elements that meet there, in the order of `surface/position`.
    """

    quantity: Literal["tangential", "xx", "yy", "xy", "surface", "none"] | None = None


class ShapeVariable(InputTable):
    """A parameter that moves the nodes of a spatial mesh: x = x_file + value * field."""

    field: FileName  # (.npy, .npz, .csv) displacement x, y, z of every node of the mesh file, per unit of the variable
    value: FiniteFloat = 0.0


class BodyFile(InputTable):
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
