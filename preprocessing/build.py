"""From skin.toml to the reduced model: every step of the preprocessing, in order."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.airfoil_table import read_start
from preprocessing.assembly import assemble
from preprocessing.basis_choice import BasisChoice
from preprocessing.discretisation import DesignSpace, Discretisation, positions
from preprocessing.geometry import Geometry, Remark, at_key, read_geometry
from preprocessing.gmsh_session import load_gmsh
from preprocessing.patches import distribute
from preprocessing.reduced import reduce
from preprocessing.skin_file import Place, SkinFile, read_skin_file
from toolkit.errors import InputError
from toolkit.reduced_model import Mesh, ReducedModel, Shape
from toolkit.reduced_model_file import SCHEMA_VERSION

WRITER_VERSION = "0.1.0"
"""Version of this distribution; part of the input hash, so that a new version builds its files again."""

_CLAMPED_NODE = {"F": 0, "G": -1}


def build(path: str | Path, remark: Remark | None = None) -> ReducedModel:
    """Build the reduced model that skin.toml describes.

    Parameters
    ----------
    path : str or Path
        skin.toml; the paths of the airfoil files are relative to it.
    remark : callable
        Called with every repair of an airfoil file and every warning about it or the thickness, in words.

    Raises
    ------
    InputError
        A file is missing or cannot be meant; the message names the file and the key.
    """
    path = Path(path)
    file = read_skin_file(path)
    return _reduced_model(path, file, input_hash(path, file), read_geometry(path, file, remark))


def input_hash(path: str | Path, file: SkinFile) -> str:
    """SHA-256 of all that the result depends on: skin.toml, both airfoil files, schema and writer version.

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
    return digest.hexdigest()


def _measured(content: bytes) -> bytes:
    """The content behind its length, so that no byte can change from one file to the next unnoticed."""
    return f" {len(content)} ".encode() + content


def _airfoil_bytes(path: Path) -> bytes:
    try:
        return read_start(path)
    except OSError as error:
        raise InputError(
            f"the airfoil file {str(path)!r} cannot be read ({error.strerror}). Mend the path; it is relative to the TOML file."
        ) from error


def _reduced_model(path: Path, file: SkinFile, hash_of_inputs: str, geometry: Geometry) -> ReducedModel:
    space = design_space(path, file, geometry)
    found = reduce(space, BasisChoice(), _CLAMPED_NODE[file.skin.clamp], file.skin.clamp)
    mesh, z = geometry.mesh, found.basis.z
    return ReducedModel(
        **found.fields(space, file.units),
        input_hash=hash_of_inputs,
        writers={"ffrf-toolkit": WRITER_VERSION, "gmsh": load_gmsh().__version__, "numpy": np.__version__},
        shape=Shape(positions(z), geometry.target, geometry.arc_lengths),
        mesh=Mesh(mesh.nodes, mesh.connectivity, z, geometry.outline, geometry.target_outline),
    )


def design_space(path: Path, file: SkinFile, geometry: Geometry) -> DesignSpace:
    """All designs of the skin."""
    section = {**file.section.model_dump(), **file.material.model_dump(), "damping_mass": file.damping.mass}
    section["damping_stiffness"] = file.damping.stiffness
    parameters = distribute(section, {}, (), file.skin.elements)

    def discretise(_values: Mapping[str, Any]) -> Discretisation:
        parts = assemble(geometry.mesh, parameters.patches)
        places = {name: _arc_length(path, name, place, geometry) for name, place in file.interface_points.items()}
        return Discretisation(geometry.mesh, geometry.arc_lengths, parts, places, geometry.target)

    return DesignSpace(parameters.values, parameters.quantities, frozenset(parameters.values), discretise)


def _arc_length(path: Path, name: str, place: Place, geometry: Geometry) -> Any:
    with at_key(path, f"interface_points.{name}"):
        return geometry.skin.locate(**place.where, stations=geometry.arc_lengths)
