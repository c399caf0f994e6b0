"""From body.toml to the reduced model: every step of the preprocessing of solids, in order."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.assembly.solids.contraction import contractions
from preprocessing.assembly.solids.parts import QUANTITIES
from preprocessing.basis.basis_choice import BasisChoice
from preprocessing.basis.reduction import clamped_in_tangent_frame
from preprocessing.basis.solids.basis import SolidShapes, solid_shapes
from preprocessing.basis.solids.ties import Freedom, freedom
from preprocessing.discretisation.body_change import BodyChange, rate_of
from preprocessing.discretisation.discretisation import STEP
from preprocessing.discretisation.surface_parts import pressure_on, surface_of
from preprocessing.foreign_files.bounds import LARGEST_FILE
from preprocessing.input.at_key import at_key
from preprocessing.input.input_files import origin
from preprocessing.mesh.included_files import drawn_on
from preprocessing.mesh.outline import BoundaryLines
from preprocessing.mesh.solid_mesh import rigid_motions
from preprocessing.recipes.skin.build import WRITER_VERSION
from preprocessing.recipes.solids.body_file import BodyFile, read_body_file
from preprocessing.recipes.solids.changed_body import changed_body
from preprocessing.recipes.solids.discrete_body import DiscreteBody, discrete_body
from preprocessing.reduction.stored_entries import ROUND_OFF, derivatives, polynomials_without_round_off, without_round_off
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.regular_file import read_whole
from toolkit.foundation.units import unit
from toolkit.reduced_model.file import SCHEMA_VERSION
from toolkit.reduced_model.model import MEAN_AXES, InterfacePoint, Outline, ReducedModel, StressPoints


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
    points = len(found["invariants"].stress_operator)
    return ReducedModel(
        **found,
        dimension=body.mesh.dimension,
        units=file.units,
        nominal_units={name: unit(file.units, QUANTITIES.get(name, "none")) for name in found["nominal"]},
        input_hash=body_hash(path, file, {**values, **keys}),
        **origin(path, body_inputs(path, file), values),
        writers={"ffrf-toolkit": WRITER_VERSION} | {name: version(name) for name in ("scikit-fem", "meshio", "numpy", "scipy")},
        stress=StressPoints(np.arange(points), np.zeros(points, int), np.ones(points, int)),
    )


def body_inputs(path: Path, file: BodyFile) -> list[Path]:
    """The files that body.toml names, and those that its mesh draws on.

    Raises
    ------
    InputError
        A file that the mesh includes is there twice.
    """
    drawn = drawn_on(path.parent / file.mesh.file) if file.mesh else []
    return [*(path.parent / name for name in file.inputs), *drawn]


def body_hash(path: Path, file: BodyFile, changes: Mapping[str, Any] | None = None) -> str:
    """SHA-256 of all that the result depends on: body.toml, the files of `body_inputs`, changes, schema and writer version.

    Raises
    ------
    InputError
        One of the files cannot be read.
    """
    digest = hashlib.sha256(f"body, schema {SCHEMA_VERSION}, writer {WRITER_VERSION}".encode())
    for each in (path, *body_inputs(path, file)):
        try:
            content = read_whole(each, LARGEST_FILE)
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
    polynomials of these. Poisson's ratio turns the shapes, unless they are frozen, and places of nodes change all; these have derivatives.
    """
    by, free = contractions(body.mesh), freedom(body.mesh, body.clamped, body.ties)
    matrices = body.parts.at(body.values)
    mass, stiffness = ((free.map.T @ matrix @ free.map).tocsr() for matrix in (matrices.mass, matrices.stiffness))
    motions = free.coordinates_of(rigid_motions(body.mesh.nodes), body.ties)
    shapes = solid_shapes(choice, mass, stiffness, motions, free.places(body.mesh.nodes, body.ties), free, body.ties)
    z = np.column_stack([body.mesh.nodes.ravel(), free.map @ shapes.columns])
    rates = {}
    for parameter, change in body.changes.items():
        d_z = _basis_rates(body, matrices, change, choice, free, shapes)
        rates[parameter] = vars(by.contract_derivative(matrices, change.matrices, z, d_z=d_z)) | _item_rates(change, z, d_z)
    nominal, computed = {**body.values, **body.others}, choice.kind != "full"
    interfaces = {name: _interface(*each.motion(z), body.mesh.size) for name, each in body.ties.items()}
    invariants, polynomials = by.contract(matrices, z), by.polynomials(body.parts, list(nominal), z, computed=computed)
    found = derivatives(invariants, rates, list(nominal), computed, interfaces)
    if not computed:
        polynomials = polynomials_without_round_off(polynomials, invariants, list(nominal.values()))
        invariants = without_round_off(invariants)
    return {
        "reference_condition": MEAN_AXES if choice.boundary == "free" else clamped_in_tangent_frame(f"the nodes of {clamp}"),
        "basis": shapes.words,
        "nominal": nominal,
        "invariants": invariants,
        "derivatives": found,
        "affine": polynomials,
        **_boundary_parts(body, z),
        "interfaces": interfaces,
    }


def _basis_rates(
    body: DiscreteBody, matrices: Any, change: BodyChange, choice: BasisChoice, free: Freedom, shapes: SolidShapes
) -> np.ndarray:
    """dZ = [dxi, dPsi] (n, 1 + n_f), where Psi = T Psi^; frozen shapes are the same at every design."""
    d_z = np.zeros((body.mesh.n, 1 + shapes.columns.shape[1]))
    d_z[:, 0] = change.motion
    if choice.derivative == "differentiated":
        stepped = change.freedom(body.clamped)
        on_independent = change.on(free, stepped, matrices, shapes.averaged)
        d_z[:, 1:] = free.map @ shapes.rates(on_independent) + rate_of(stepped.map) @ shapes.columns
    return d_z


def _boundary_parts(body: DiscreteBody, z: np.ndarray) -> dict[str, Any]:
    """Outline of a plane body; surface of a spatial one, and pressures on it."""
    if body.boundary is None or isinstance(body.boundary, BoundaryLines):
        return {"outline": None if body.boundary is None else _outline(body.boundary, z)}
    loads = {name: pressure_on(each.normals(), z) for name, each in body.pressure_surfaces.items()}
    return {"surface": surface_of(body.boundary, z), "surface_loads": loads}


def _outline(lines: BoundaryLines, z: np.ndarray) -> Outline:
    """The nodes on the boundary, and its edges between them."""
    edges = np.where(lines.edges[:, [2]] >= 0, lines.edges[:, [0, 2, 1]], lines.edges[:, [0, 0, 1]])
    nodes, number = np.unique(edges, return_inverse=True)
    return Outline(z.reshape(-1, 2, z.shape[1])[nodes], number.reshape(edges.shape))


def _interface(position: np.ndarray, rotation: np.ndarray, size: float) -> InterfacePoint:
    """A point of a solid, which lies on no curve: its arc length is 0 and cannot change.

    The middle of a ring of nodes is zero but for round-off, as is the rotation of the undeformed body.
    """
    for array, scale in ((position, size), (rotation, 1.0)):
        array[..., 0] = np.where(np.abs(array[..., 0]) > ROUND_OFF * scale, array[..., 0], 0.0)
    return InterfacePoint(np.zeros(()), np.zeros(2), position[None], rotation[None])


def _item_rates(change: BodyChange, z: np.ndarray, d_z: np.ndarray) -> dict[str, np.ndarray]:
    """Derivatives of interface points and pressures."""
    stepped = z + 1j * STEP * d_z
    found: dict[str, np.ndarray] = {}
    for name, each in change.ties.items():
        position, rotation = each.motion(stepped)
        found |= {f"interfaces.{name}.position": position[None], f"interfaces.{name}.rotation": rotation[None]}
    for name, normals in change.normals.items():
        load = pressure_on(normals, stepped)
        found |= {f"surface_loads.{name}.force": load.force, f"surface_loads.{name}.moment": load.moment}
    return {name: rate_of(item) for name, item in found.items()}
