"""From body.toml to the reduced model: every step of the preprocessing of solids, in order."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.at_key import at_key
from preprocessing.basis_choice import BasisChoice
from preprocessing.build import WRITER_VERSION
from preprocessing.invariants import contract, contract_derivative, listed, polynomials
from preprocessing.reduction import clamped_in_tangent_frame
from preprocessing.solids.body_file import BodyFile, read_body_file
from preprocessing.solids.changed_body import changed_body
from preprocessing.solids.discrete_body import DiscreteBody, discrete_body
from preprocessing.solids.outline import BoundaryLines
from preprocessing.solids.parts import QUANTITIES
from preprocessing.solids.solid_basis import solid_shapes
from preprocessing.solids.solid_mesh import rigid_motions
from preprocessing.solids.ties import freedom
from toolkit.errors import InputError
from toolkit.reduced_model import MEAN_AXES, InterfacePoint, Outline, ReducedModel, StressPoints
from toolkit.reduced_model_file import SCHEMA_VERSION
from toolkit.units import unit

PER_NODE = 2
"""Coordinates of a node: x and y."""


def build_body(
    path: str | Path, values: Mapping[str, float] | None = None, keys: Mapping[str, Any] | None = None
) -> ReducedModel:
    """Build the reduced model that body.toml describes.

    Parameters
    ----------
    path : str or Path
        body.toml; the paths of other files in it are relative to it.
    values : parameter -> value
        Another design than that of the file, see `changed_body`.
    keys : key -> value
        Other keys than those of the file, for example {"basis": {...}}.

    Raises
    ------
    InputError
        A file is missing or cannot be meant; the message names the file and the key.
    """
    path, values, keys = Path(path), values or {}, keys or {}
    file = changed_body(read_body_file(path), values, keys, path)
    body = discrete_body(path, file)
    with at_key(path, "basis"):
        found = _reduced(body, file.basis.choice(), file.clamp.words if file.clamp else "")
    points = body.parts.n_stress
    return ReducedModel(
        **found,
        dimension=body.mesh.dimension,
        units=file.units,
        nominal_units={name: unit(file.units, QUANTITIES[name]) for name in found["nominal"]},
        input_hash=body_hash(path, file, {**values, **keys}),
        writers={"ffrf-toolkit": WRITER_VERSION} | {name: version(name) for name in ("scikit-fem", "meshio", "numpy", "scipy")},
        stress=StressPoints(np.arange(points), np.zeros(points, int), np.ones(points, int)),
    )


def body_hash(path: Path, file: BodyFile, changes: Mapping[str, Any] | None = None) -> str:
    """SHA-256 of all that the result depends on: body.toml, the files that it names, changes, schema and writer version.

    Raises
    ------
    InputError
        One of the files cannot be read.
    """
    digest = hashlib.sha256(f"body, schema {SCHEMA_VERSION}, writer {WRITER_VERSION}".encode())
    for each in (path, *(path.parent / name for name in file.inputs)):
        try:
            content = each.read_bytes()
        except OSError as error:
            raise InputError(
                f"{str(each)!r} cannot be read ({error.strerror}). Mend the path in {path.name}; it is relative to that file."
            ) from error
        digest.update(f" {len(content)} ".encode() + content)
    if changes:
        digest.update(repr(sorted(changes.items())).encode())
    return digest.hexdigest()


def _reduced(body: DiscreteBody, choice: BasisChoice, clamp: str) -> dict[str, Any]:
    """Basis and contractions: those fields of the reduced model that follow from them.

    All shapes stay what they are when modulus, density, width or damping change, because their span does: so the invariants are exact
    polynomials of these. Poisson's ratio turns the shapes, unless they are frozen, and has a derivative.
    """
    free = freedom(body.mesh, body.clamped, body.ties)
    matrices = body.parts.at(body.values)
    mass, stiffness = (free.map.T @ matrix @ free.map for matrix in (matrices.mass, matrices.stiffness))
    motions = rigid_motions(body.mesh.nodes)
    shapes = solid_shapes(choice, mass.tocsr(), stiffness.tocsr(), free.coordinates_of(motions, body.ties), free, body.ties)
    z = np.column_stack([body.mesh.nodes.ravel(), free.map @ shapes.columns])
    rates = {}
    for parameter, d_matrices in body.by_poisson_ratio.items():
        d_z = np.zeros_like(z)
        if choice.derivative == "differentiated":
            d_z[:, 1:] = free.map @ shapes.rates((free.map.T @ d_matrices.stiffness @ free.map).tocsr())
        rates[parameter] = {**vars(contract_derivative(matrices, d_matrices, z, d_z, PER_NODE)), **_interface_rates(body, d_z)}
    nominal = {**body.values, **body.poisson_ratio}
    return {
        "reference_condition": MEAN_AXES if choice.boundary == "free" else clamped_in_tangent_frame(f"the nodes of {clamp}"),
        "basis": shapes.words,
        "nominal": nominal,
        "invariants": contract(matrices, z, PER_NODE),
        "derivatives": listed(rates, list(nominal)),
        "affine": polynomials(body.parts, list(nominal), z, PER_NODE),
        "outline": None if body.outline is None else _outline(body.outline, z),
        "interfaces": {name: _interface(*each.motion(z)) for name, each in body.ties.items()},
    }


def _outline(lines: BoundaryLines, z: np.ndarray) -> Outline:
    """The nodes on the boundary, and its edges between them."""
    edges = np.where(lines.edges[:, [2]] >= 0, lines.edges[:, [0, 2, 1]], lines.edges[:, [0, 0, 1]])
    nodes, number = np.unique(edges, return_inverse=True)
    return Outline(z.reshape(-1, PER_NODE, z.shape[1])[nodes], number.reshape(edges.shape))


def _interface(position: np.ndarray, rotation: np.ndarray) -> InterfacePoint:
    """A point of a solid, which lies on no curve: its arc length is 0 and cannot change."""
    return InterfacePoint(np.zeros(()), np.zeros(2), position[None], rotation[None])


def _interface_rates(body: DiscreteBody, d_z: np.ndarray) -> dict[str, np.ndarray]:
    found: dict[str, np.ndarray] = {}
    for name, each in body.ties.items():
        moved = each.rows @ d_z
        found |= {f"interfaces.{name}.position": moved[None, :2], f"interfaces.{name}.rotation": moved[None, 2]}
    return found
