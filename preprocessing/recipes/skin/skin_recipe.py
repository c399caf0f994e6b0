"""From skin.toml to the reduced model: every step of the preprocessing, in order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from preprocessing.airfoil.table import LARGEST_FILE
from preprocessing.discretisation.discretisation import DesignSpace
from preprocessing.elements.kinds.beams import SpatialBeam
from preprocessing.input.at_key import at_key
from preprocessing.mesh.gmsh_session import load_gmsh
from preprocessing.recipes.beam_surface import beam_surface
from preprocessing.recipes.checked_file import validated
from preprocessing.recipes.recipe import Recipe, Remark, Seal
from preprocessing.recipes.skin.changed_design import put_value
from preprocessing.recipes.skin.changed_keys import with_keys
from preprocessing.recipes.skin.geometry import Geometry, read_geometry
from preprocessing.recipes.skin.skin_file import SkinFile
from preprocessing.recipes.skin.skin_space import design_space, differentiable
from preprocessing.reduction.reduced import SECTIONS, Reduced, element_parts, reduce
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.meant_path import meant_path
from toolkit.foundation.files.regular_file import read_start
from toolkit.reduced_model.model import Mesh, Shape

_CLAMPED_NODE = {"F": 0, "G": -1}


class SkinRecipe(Recipe[SkinFile]):
    """Recipe of a skin cut from an airfoil.

    Remarks are every repair of an airfoil file, every warning about it or the thickness, and every parameter of the shape by which
    there is no derivative.
    """

    name = "skin.toml"
    schema = SkinFile
    seal = Seal(lengths_of_changes=True)

    @classmethod
    def means(cls, content: Mapping[str, Any]) -> bool:
        return "airfoil" in content

    @property
    def parts(self) -> tuple[str, ...]:
        picture = "mesh" if self.file.dimension == 2 else "surface"
        basis = self.file.basis
        own = element_parts(basis.kind) + SECTIONS + basis.parts + basis.richer_parts
        return ("invariants", "derivatives", "affine", "interfaces", "stress", "shape", picture, *own)

    def _named(self) -> list[Path]:
        return [self.path.parent / name for name in (self.file.airfoil.file, self.file.airfoil.target)]

    def _content(self, each: Path) -> bytes:
        """Content of an input for the hash: of an airfoil file as much as decides whether it can be used."""
        if each == self.path:
            return super()._content(each)
        with at_key(self.path, "airfoil.file" if each == self.inputs[1] else "airfoil.target"):
            return _airfoil_bytes(each)

    def _hash_mark(self) -> str:
        return "rotary inertia, " if self.file.rotary_inertia else ""

    def _changed(self, values: Mapping[str, float], keys: Mapping[str, Any]) -> SkinFile:
        file = validated(SkinFile, self._content_at(values), "the changed design")
        return with_keys(file, keys, lambda: read_geometry(self.path, file).arc_lengths) if keys else file

    def _put(self, content: dict[str, Any], parameter: str, value: float) -> None:
        put_value(content, self.file, parameter, value)

    def _designs(self, remark: Remark | None) -> tuple[Geometry, DesignSpace]:
        geometry = read_geometry(self.path, self.file, remark)
        return geometry, differentiable(design_space(self.path, self.file, self.values, geometry), remark)

    def _fields(self, designs: tuple[Geometry, DesignSpace]) -> dict[str, Any]:
        geometry, space = designs
        clamp = self.file.clamp
        found = reduce(space, self.file.basis.choice(), _CLAMPED_NODE[clamp], clamp)
        return {**found.fields(self.file.units), **_shape_and_pictures(found, geometry)}

    def _writers(self) -> dict[str, str]:
        return {"gmsh": load_gmsh().__version__, **super()._writers()}


def _airfoil_bytes(path: Path) -> bytes:
    try:
        return read_start(path, LARGEST_FILE + 1)
    except OSError as error:
        raise InputError(
            f"the airfoil file {str(path)!r} cannot be read ({error.strerror}{meant_path(path, error)}). Fix the path; it is relative to "
            "the TOML file."
        ) from error


def _shape_and_pictures(found: Reduced, geometry: Geometry) -> dict[str, Any]:
    """Fields of the reduced model for shape and pictures: the mesh in the plane, the surface in space.

    The shape is compared in the plane of the section in both.
    """
    z, mesh, elements = found.basis.z, geometry.mesh, found.space.nominal()
    shapes = {"shape": Shape(elements.positions(z)[:, :2], geometry.target, geometry.arc_lengths)}
    if found.richer is not None:
        shapes["richer_shape"] = replace(shapes["shape"], position=elements.positions(found.richer.basis.z)[:, :2])
    if isinstance(elements.element, SpatialBeam):
        return {**shapes, **beam_surface(found, elements.element)}
    return {**shapes, "mesh": Mesh(mesh.nodes, mesh.connectivity, z, geometry.outline, geometry.target_outline)}
