"""From body.toml to the reduced model.

Flexible bodies come from a finite-element mesh of any program, or from finished matrices, in the plane and in space.
A spatial body needs a mesh of tetrahedra, hexahedra or wedges with named groups, and a body.toml beside it:

    units = "m-kg-s"
    mesh.file = "arm.msh"
    material = { youngs_modulus = 70e9, density = 2700.0, poisson_ratio = 0.33 }
    clamp.group = "hub"
    interface_points.tip = { group = "bore", tie = "rigid" }
    pressure_surfaces.skin.group = "outside"
    basis = { kind = "craig-bampton", count = 12 }

A slender body that bends far is cut across into groups of elements, for several floating frames; it has no basis then:

    pieces.groups = ["root", "middle", "outer"]

Then `ffrf-preprocess body.toml`, or `preprocessing.save(preprocessing.build("body.toml"), "body.h5")`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from preprocessing.builders.body_file import BodyFile
from preprocessing.builders.recipe import Recipe, Remark, Seal
from preprocessing.builders.tables import Keys
from preprocessing.foreign_files.included_files import drawn_on
from preprocessing.mesh.solid_mesh import SolidMesh
from preprocessing.reduction.reduced import ELEMENT_PARTS, mesh_composition
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.composition import Attributes
from toolkit.reduced_model.model import ReducedModel
from toolkit.reduced_model.told_body import told_left_out

if TYPE_CHECKING:
    from preprocessing.builders.cut_mesh import PieceBodies
    from preprocessing.builders.discrete_body import DiscreteBody


PLACES = {
    "youngs_modulus": ("material", "youngs_modulus"),
    "density": ("material", "density"),
    "poisson_ratio": ("material", "poisson_ratio"),
    "width": ("section", "width"),
    "damping_mass": ("damping", "mass"),
    "damping_stiffness": ("damping", "stiffness"),
}
"""Keys of a body's parameters in body.toml, besides its shape variables."""


class BodyRecipe(Recipe[BodyFile, "DiscreteBody | PieceBodies"]):
    """Recipe of a body with a mesh of solid elements, or with finished matrices.

    What needs scikit-fem is loaded when the body is built: it takes a second.
    """

    name = "body.toml"
    schema = BodyFile
    seal = Seal("body, ")

    @property
    def parts(self) -> tuple[str, ...]:
        cut = () if self.file.pieces is None else (*ELEMENT_PARTS, "pieces")
        return ("invariants", "derivatives", "affine", "interfaces", "stress", *cut, *self.file.basis.parts)

    @classmethod
    def means(cls, content: Mapping[str, object]) -> bool:
        return "mesh" in content or "matrices" in content

    def _named(self) -> list[Path]:
        drawn = drawn_on(self.path.parent / self.file.mesh.file) if self.file.mesh else []
        return [*(self.path.parent / name for name in self.file.inputs), *drawn]

    def _places(self) -> dict[str, Keys]:
        return {**PLACES, **{name: ("shape_variables", name, "value") for name in self.file.shape_variables}}

    def _content_at(self, values: Mapping[str, float]) -> dict[str, object]:
        if values and self.file.matrices is not None:
            raise InputError(
                f"{str(self.path)!r}: finished matrices hold for the values that they were made with. Change {', '.join(values)} in the "
                "scene, where the model follows it exactly, or export other matrices."
            )
        return super()._content_at(values)

    def _designs(self, remark: Remark | None) -> DiscreteBody | PieceBodies:
        try:
            from preprocessing.builders.cut_mesh import piece_bodies
            from preprocessing.builders.discrete_body import discretised
            from preprocessing.builders.named_mesh import named_mesh, remarks_on_masses
            from preprocessing.mesh.overlaps import misfit_told, slit_told
        except ImportError as error:
            raise InputError(
                f"meshed bodies need scikit-fem, which cannot be loaded ({error}). Install it with: pip install "
                "'ffrf-toolkit[preprocessing]'."
            ) from error
        named = named_mesh(self.path, self.file)
        told = [slit_told(named.mesh), misfit_told(named.mesh)] if named.mesh.blocks else []
        if remark is not None:
            for each in (*filter(None, told), *told_of_file(named.mesh), *remarks_on_masses(named)):
                remark(f"{self.path.name}: {each}")
        if self.file.pieces is not None:
            return piece_bodies(named)
        body = discretised(named)
        if remark is not None:
            for each in body.mesh.remarks[len(named.mesh.remarks) :]:
                remark(f"{self.path.name}: {each}")
        return body

    def _model(self, designs: DiscreteBody | PieceBodies) -> ReducedModel:
        from preprocessing.builders.joined_model import PieceBodies, joined_model
        from preprocessing.builders.reduced_body import reduced_body

        file = self.file
        if isinstance(designs, PieceBodies):
            return replace(joined_model(designs), composition=_composition(designs.whole, file))
        model = reduced_body(designs, file.basis.choice(), file.clamp.words if file.clamp else "", file.units)
        return replace(model, composition=_composition(designs, file))

    def _writers(self) -> dict[str, str]:
        return {name: version(name) for name in ("scikit-fem", "meshio", "numpy", "scipy")}


def told_of_file(mesh: SolidMesh) -> Iterator[str]:
    """Remarks on the reading of a mesh file, and on what of it is not part of the body."""
    yield from mesh.remarks
    if mesh.left_out:
        yield f"not part of the body: {told_left_out([each._asdict() for each in mesh.left_out])}."


def _composition(body: DiscreteBody, file: BodyFile) -> Attributes:
    """Composition of the body; the volume of a plane one is known if its width is."""
    from preprocessing.elements.elasticity import volume_of
    from preprocessing.elements.solid_elements import element_blocks

    plane = body.mesh.dimension == 2
    width = file.section.width if plane and file.section else None if plane else 1.0
    volume = None
    if body.mesh.blocks and width is not None:
        volume = width * volume_of(body.elastic.blocks if body.elastic else element_blocks(body.mesh))
    tied = {name: each.nodes for name, each in body.ties.items()}
    return mesh_composition(body.mesh, volume, body.clamped, tied)
