"""From skin.toml to the reduced model: every step of the preprocessing, in order."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.airfoil.table import LARGEST_FILE
from preprocessing.assembly.assembly import assemble
from preprocessing.discretisation.discretisation import DesignSpace, Discretisation, FiniteElements, positions
from preprocessing.discretisation.spatial_discretisation import SpatialDiscretisation
from preprocessing.discretisation.spatial_discretisation import positions as spatial_positions
from preprocessing.elements.patches import distribute
from preprocessing.input.at_key import at_key
from preprocessing.input.input_files import origin
from preprocessing.mesh.gmsh_session import load_gmsh
from preprocessing.recipes.skin.changed_design import changed
from preprocessing.recipes.skin.changed_keys import with_keys
from preprocessing.recipes.skin.geometry import Geometry, Remark, read_geometry
from preprocessing.recipes.skin.shape_parameters import shape_parameters
from preprocessing.recipes.skin.skin_file import SkinFile, read_skin_file
from preprocessing.recipes.skin.skin_tables import Place
from preprocessing.recipes.skin.spatial_skin import spatial_skin
from preprocessing.reduction.reduced import Reduced, reduce
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.regular_file import read_start
from toolkit.reduced_model.file import SCHEMA_VERSION
from toolkit.reduced_model.model import Mesh, ReducedModel, Shape

WRITER_VERSION = "0.1.0"
"""Version of this distribution; part of the input hash, so that a new version builds its files again."""

_CLAMPED_NODE = {"F": 0, "G": -1}


def build(
    path: str | Path,
    remark: Remark | None = None,
    values: Mapping[str, float] | None = None,
    keys: Mapping[str, Any] | None = None,
) -> ReducedModel:
    """Build the reduced model that skin.toml describes.

    Parameters
    ----------
    path : str or Path
        skin.toml; the paths of the airfoil files are relative to it.
    remark : callable
        Called with every repair of an airfoil file, every warning about it or the thickness, and every parameter of the shape by
        which there is no derivative, in words.
    values : parameter -> value
        Another design than that of the file, see `changed_design.changed`.
    keys : key -> value
        Another basis or mesh than that of the file, see `changed_keys.with_keys`.

    Raises
    ------
    InputError
        A file is missing or cannot be meant; the message names the file and the key.
    """
    path, values, keys = Path(path), values or {}, keys or {}
    file = file_at(path, values, keys)
    return _reduced_model(path, file, values, keys, read_geometry(path, file, remark), remark)


def file_at(path: Path, values: Mapping[str, float], keys: Mapping[str, Any]) -> SkinFile:
    """What stands in skin.toml, with another design and other keys.

    Raises
    ------
    InputError
        As `build`.
    """
    file = changed(read_skin_file(path), values)
    return with_keys(file, keys, lambda: read_geometry(path, file).arc_lengths) if keys else file


def input_hash(path: str | Path, file: SkinFile, values: Mapping[str, Any] | None = None) -> str:
    """SHA-256 of all that the result depends on: skin.toml, both airfoil files, changes of design and keys, schema and writer version.

    Raises
    ------
    InputError
        One of the files cannot be read.
    """
    path = Path(path)
    digest = hashlib.sha256(f"schema {SCHEMA_VERSION}, writer {WRITER_VERSION}".encode())
    digest.update(_measured(path.read_bytes()))
    for key in ("file", "target"):
        with at_key(path, f"airfoil.{key}"):
            digest.update(_measured(_airfoil_bytes(path.parent / getattr(file.airfoil, key))))
    if values:
        digest.update(_measured(repr(sorted(values.items())).encode()))
    return digest.hexdigest()


def _measured(content: bytes) -> bytes:
    """The content behind its length, so that no byte can change from one file to the next unnoticed."""
    return f" {len(content)} ".encode() + content


def _airfoil_bytes(path: Path) -> bytes:
    try:
        return read_start(path, LARGEST_FILE + 1)
    except OSError as error:
        raise InputError(
            f"the airfoil file {str(path)!r} cannot be read ({error.strerror}). Mend the path; it is relative to the TOML file."
        ) from error


def _reduced_model(
    path: Path, file: SkinFile, values: Mapping[str, float], keys: Mapping[str, Any], geometry: Geometry, remark: Remark | None
) -> ReducedModel:
    changes, values = values, {**values, **keys}
    space = differentiable(design_space(path, file, values, geometry), remark)
    with at_key(path, "basis"):
        found = reduce(space, file.basis.choice(), _CLAMPED_NODE[file.skin.clamp], file.skin.clamp)
    return ReducedModel(
        **found.fields(file.units),
        input_hash=input_hash(path, file, values),
        **origin(path, [path.parent / file.airfoil.file, path.parent / file.airfoil.target], changes),
        writers={"ffrf-toolkit": WRITER_VERSION, "gmsh": load_gmsh().__version__, "numpy": np.__version__},
        **_shape_and_pictures(found, geometry),
    )


def _shape_and_pictures(found: Reduced, geometry: Geometry) -> dict[str, Any]:
    """In the plane the mesh, in space the surface; the shape is compared in the plane of the section in both."""
    z, mesh, elements = found.basis.z, geometry.mesh, found.space.nominal()
    if isinstance(elements, SpatialDiscretisation):
        in_plane = spatial_positions(z)[:, :2]
        return {
            "shape": Shape(in_plane, geometry.target, geometry.arc_lengths),
            "surface": elements.surface(z, found.space.values),
        }
    return {
        "shape": Shape(positions(z), geometry.target, geometry.arc_lengths),
        "mesh": Mesh(mesh.nodes, mesh.connectivity, z, geometry.outline, geometry.target_outline),
    }


def design_space(path: Path, file: SkinFile, values: Mapping[str, float], geometry: Geometry) -> DesignSpace:
    """All designs of the skin: section, by groups of elements; Poisson's ratio, where it enters; and shape.

    Parameters
    ----------
    values : those of parameters of single elements count, the others stand in `file` already
    """
    body = {**file.section.model_dump(), **file.material.model_dump()}
    body |= {"damping_mass": file.damping.mass, "damping_stiffness": file.damping.stiffness}
    with at_key(path, "groups"):
        parameters = distribute(body, file.groups, file.skin.separate, file.skin.elements)
    section = {name: values.get(name, value) for name, value in parameters.values.items()}
    shape = shape_parameters(file)
    in_plane, wide = file.dimension == 2, file.material.state == "plane-strain"
    ratio = {"poisson_ratio": file.material.poisson_ratio or 0.0} if wide or not in_plane else {}

    def discretise(design: Mapping[str, Any]) -> FiniteElements:
        moved = {name: design[name] for name in shape if design[name] != shape[name]}
        at = geometry.moved(moved) if moved else geometry
        factor = 1 / (1 - design["poisson_ratio"] ** 2) if wide else 1.0
        places = {name: _arc_length(path, name, place, at) for name, place in file.interface_points.items()}
        if not in_plane:
            return spatial_skin(at, parameters.patches, places, factor, design["poisson_ratio"])
        return Discretisation(at.mesh, at.arc_lengths, assemble(at.mesh, parameters.patches, factor), places, at.target)

    lengths = {name: "none" if name == "y_scale" else "length" for name in shape}
    quantities = {**parameters.quantities, **dict.fromkeys(ratio, "none"), **lengths}
    return DesignSpace({**section, **ratio, **shape}, quantities, frozenset(section), discretise)


def differentiable(space: DesignSpace, remark: Remark | None) -> DesignSpace:
    """The space without the parameters of the shape that have no derivative; `remark` is told why."""
    lost, steps = {}, {}
    for name in space.values:
        if name not in space.in_monomials:
            try:
                steps[name] = space.stepped(name)
                steps[name].interface_rows()
            except InputError as error:
                lost[name] = str(error)
                if remark is not None:
                    remark(f"the model will have no derivatives by {name}: {error}")
    values, discretise = space.values, space.discretise
    return replace(
        space,
        values={name: value for name, value in values.items() if name not in lost},
        quantities={name: meaning for name, meaning in space.quantities.items() if name not in lost},
        discretise=lambda design: discretise({**values, **design}),
        steps=steps,
    )


def _arc_length(path: Path, name: str, place: Place, geometry: Geometry) -> Any:
    with at_key(path, f"interface_points.{name}"):
        return geometry.skin.locate(**place.where, stations=geometry.arc_lengths)
