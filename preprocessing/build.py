"""From skin.toml to the reduced model: every step of the preprocessing, in order."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

from preprocessing.airfoil_table import read_start
from preprocessing.assembly import Rayleigh, assemble, derivative, matrices_at
from preprocessing.geometry import Geometry, Remark, at_key, read_geometry
from preprocessing.gmsh_session import load_gmsh
from preprocessing.interface import interface_point
from preprocessing.invariants import contract, contract_derivative, nonzero, polynomials
from preprocessing.reduction import Basis, tangent_frame
from preprocessing.section import PARAMETERS, Section
from preprocessing.skin_file import SkinFile, read_skin_file
from preprocessing.stress import stress_points
from toolkit.errors import InputError
from toolkit.reduced_model import InterfacePoint, Mesh, ReducedModel, Shape
from toolkit.reduced_model_file import SCHEMA_VERSION
from toolkit.units import unit

WRITER_VERSION = "0.1.0"
"""Version of this distribution; part of the input hash, so that a new version builds its files again."""

QUANTITIES = {"youngs_modulus": "stress", "density": "density", "thickness": "length", "width": "length"}
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
    mesh = geometry.mesh
    section = Section(file.material.youngs_modulus, file.material.density, file.section.thickness, file.section.width)
    parts = assemble(mesh, Rayleigh(file.damping.mass, file.damping.stiffness))
    basis = tangent_frame(mesh.nodes, _CLAMPED_NODE[file.skin.clamp], file.skin.clamp)
    matrices = matrices_at(parts, section)
    rates = {name: contract_derivative(matrices, derivative(parts, section, name), basis.z) for name in PARAMETERS}
    return ReducedModel(
        dimension=2,
        units=file.units,
        reference_condition=basis.reference_condition,
        basis=basis.description,
        nominal={name: float(getattr(section, name)) for name in PARAMETERS},
        nominal_units={name: unit(file.units, quantity) for name, quantity in QUANTITIES.items()},
        input_hash=hash_of_inputs,
        writers={"ffrf-toolkit": WRITER_VERSION, "gmsh": load_gmsh().__version__, "numpy": np.__version__},
        invariants=contract(matrices, basis.z),
        derivatives={name: nonzero(rate) for name, rate in rates.items()},
        affine=polynomials(parts, section, basis.z),
        interfaces=_interfaces(path, file, geometry, basis),
        stress=stress_points(len(mesh.connectivity)),
        shape=Shape(basis.translations, geometry.target, geometry.arc_lengths),
        mesh=Mesh(mesh.nodes, mesh.connectivity, basis.z, geometry.outline, geometry.target_outline),
    )


def _interfaces(path: Path, file: SkinFile, geometry: Geometry, basis: Basis) -> dict[str, InterfacePoint]:
    points = {}
    for name, place in file.interface_points.items():
        with at_key(path, f"interface_points.{name}"):
            arc_length = geometry.skin.locate(**place.where, stations=geometry.arc_lengths)
            points[name] = interface_point(geometry.mesh, geometry.arc_lengths, basis.z, arc_length)
    return points
