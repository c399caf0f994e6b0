"""A body of solid elements, or of finished matrices, ready for the choice of a basis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from preprocessing.assembly import Parts
from preprocessing.at_key import at_key
from preprocessing.discretisation import STEP
from preprocessing.solids.body_change import BodyChange, rate_of
from preprocessing.solids.body_file import BodyFile
from preprocessing.solids.elasticity import SolidMatrices, solid_matrices
from preprocessing.solids.elements import ElementBlock, element_blocks
from preprocessing.solids.faces import BoundaryFaces, faces_of
from preprocessing.solids.lame import lame_factors
from preprocessing.solids.matrix_file import read_matrix, read_nodes, read_square
from preprocessing.solids.mesh_file import read_mesh
from preprocessing.solids.node_motion import read_motion
from preprocessing.solids.node_sets import Boundary, faces_in, nodes_in, spread_of
from preprocessing.solids.outline import outline_of
from preprocessing.solids.parts import element_parts, finished_parts, parameters_of
from preprocessing.solids.solid_mesh import SolidMesh, rigid_motions
from preprocessing.solids.solid_stress import Rows, stress_rows
from preprocessing.solids.ties import Tie, tie
from toolkit.errors import InputError

AT_ONE_PLACE = 1e-6
"""Distance of clamped nodes, in parts of the body's extent, below which they leave the body free to turn."""


@dataclass(frozen=True, eq=False)
class DiscreteBody:
    """What precedes the choice of a basis."""

    mesh: SolidMesh
    parts: Parts
    values: Mapping[str, float]  # parameters by which the matrices are polynomials
    others: Mapping[str, float]  # the other parameters, and their nominal values
    changes: Mapping[str, BodyChange]  # what each of these changes
    clamped: np.ndarray  # numbers of nodes
    ties: Mapping[str, Tie]
    boundary: Boundary | None  # None without elements
    pressure_surfaces: Mapping[str, BoundaryFaces]


def discrete_body(path: Path, file: BodyFile) -> DiscreteBody:
    """Read and assemble all that body.toml names.

    Raises
    ------
    InputError
        Names the file, the key and what is wrong there.
    """
    unmoved, mesh, motions = _mesh(path, file)
    _refuse_other_dimension(path, file, mesh)
    named = _Named(path, file, mesh, _boundary(mesh), *_regions(path, file, unmoved))
    surfaces = _pressure_surfaces(named, unmoved)
    material, section = file.material, file.section
    made_with = {} if material is None else {"youngs_modulus": material.youngs_modulus, "density": material.density}
    made_with |= {} if section is None else {"width": section.width}
    values = dict(parameters_of(made_with, file.damping.model_dump()))
    ties = _ties(named, mesh.nodes)
    others: dict[str, float] = {}
    changes: dict[str, BodyChange] = {}
    if file.matrices is None:
        others = {"poisson_ratio": _ratio(file), **{name: variable.value for name, variable in file.shape_variables.items()}}
        parts, changes = _from_elements(named, motions, values, surfaces, ties)
    else:
        parts = _from_files(named, made_with)
    return DiscreteBody(mesh, parts, values, others, changes, named.clamped, ties, named.boundary, surfaces)


@dataclass(frozen=True, eq=False)
class _Named:
    """The file, its mesh, and the nodes of its regions: those of the mesh before shape variables move it."""

    path: Path
    file: BodyFile
    mesh: SolidMesh
    boundary: Any  # `Boundary`; None without elements
    clamped: np.ndarray
    tied: Mapping[str, np.ndarray]  # interface point -> nodes


def _regions(path: Path, file: BodyFile, mesh: SolidMesh) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Nodes of the clamp, and of every interface point."""
    tied = {}
    for name, region in file.interface_points.items():
        with at_key(path, f"interface_points.{name}"):
            tied[name] = nodes_in(mesh, region)
    return _clamped(path, file, mesh), tied


def _mesh(path: Path, file: BodyFile) -> tuple[SolidMesh, SolidMesh, dict[str, np.ndarray]]:
    """The mesh of the file, the mesh at the values of the shape variables, and the motion of its nodes by each of them."""
    if file.mesh is None:
        with at_key(path, "matrices.nodes"):
            mesh = SolidMesh(read_nodes(path.parent / str(file.matrices and file.matrices.nodes)))
            return mesh, mesh, {}
    with at_key(path, "mesh.file"):
        unmoved = mesh = read_mesh(path.parent / file.mesh.file, file.mesh.scale)
    motions = {}
    for name, variable in file.shape_variables.items():
        with at_key(path, f"shape_variables.{name}"):
            if mesh.dimension == 2:
                raise InputError(
                    "the nodes of plane meshes cannot be moved by variables. Leave [shape_variables] out, or mesh a volume."
                )
            if name in ("poisson_ratio", "youngs_modulus", "density", "damping_mass", "damping_stiffness"):
                raise InputError("this is the name of a parameter of the material. Take another one.")
            motions[name] = read_motion(path.parent / variable.field, mesh, file.mesh.scale)
            mesh = replace(mesh, nodes=mesh.nodes + variable.value * motions[name])
    return unmoved, mesh, motions


def _boundary(mesh: SolidMesh) -> Boundary | None:
    if not mesh.blocks:
        return None
    return outline_of(mesh.nodes, mesh.blocks) if mesh.dimension == 2 else faces_of(mesh.nodes, mesh.blocks)


def _refuse_other_dimension(path: Path, file: BodyFile, mesh: SolidMesh) -> None:
    """Refuse keys that bodies in the plane, or in space, do not have or need."""
    plane = mesh.dimension == 2
    if plane and file.material is not None and file.section is None:
        with at_key(path, "section"):
            raise InputError("[material] of a plane body needs [section] with width. Add it.")
    wrong = {
        "section": not plane and file.section is not None,
        "material.state": not plane and file.material is not None and file.material.state is not None,
        "pressure_surfaces": plane and bool(file.pressure_surfaces),
    }
    for key, given in wrong.items():
        if given:
            with at_key(path, key):
                raise InputError(
                    f"this body is {'plane' if plane else 'spatial'}, as its nodes and elements are, and such bodies have none. "
                    f"Leave it out, or give {'a mesh of the volume' if plane else 'nodes and elements in the plane'}."
                )


def _ratio(file: BodyFile) -> float:
    return (file.material.poisson_ratio if file.material else None) or 0.0


def _state(file: BodyFile, mesh: SolidMesh) -> str:
    return "space" if mesh.dimension == 3 else (file.material and file.material.state) or "plane-stress"


def _stress(named: _Named, blocks: list[ElementBlock], motion: np.ndarray | None = None) -> Rows:
    with at_key(named.path, "stress.quantity"):
        return stress_rows(named.file.stress.quantity, blocks, named.boundary, motion)


def _from_elements(
    named: _Named,
    motions: Mapping[str, np.ndarray],
    values: Mapping[str, float],
    surfaces: Mapping[str, BoundaryFaces],
    ties: Mapping[str, Tie],
) -> tuple[Parts, dict[str, BodyChange]]:
    """Parts of the body, and what Poisson's ratio and the shape variables change."""
    mesh, ratio, state = named.mesh, _ratio(named.file), _state(named.file, named.mesh)
    with at_key(named.path, "mesh.file"):
        blocks = element_blocks(mesh)
    matrices, rows = solid_matrices(blocks, len(mesh.nodes), mesh.dimension), _stress(named, blocks)
    lame = lame_factors(ratio, state)
    slopes = tuple(rate_of(factor) for factor in lame_factors(ratio + 1j * STEP, state))
    weightless = SolidMatrices(sparse.csr_array(matrices.scalar_mass.shape), matrices.first, matrices.shear)
    changes = {"poisson_ratio": BodyChange(element_parts(weightless, rows, slopes).at(values), mesh, ties, {})}
    for name, motion in motions.items():
        rates = element_parts(
            solid_matrices(blocks, len(mesh.nodes), mesh.dimension, motion), _stress(named, blocks, motion), lame
        )
        moved = replace(mesh, nodes=mesh.nodes + 1j * STEP * motion)
        normals = {key: BoundaryFaces(moved.nodes, each.faces).normals() for key, each in surfaces.items()}
        changes[name] = BodyChange(rates.at(values), moved, _ties(named, moved.nodes), normals)
    return element_parts(matrices, rows, lame), changes


def _from_files(named: _Named, made_with: Mapping[str, float]) -> Parts:
    path, file, mesh, boundary = named.path, named.file, named.mesh, named.boundary
    assert file.matrices is not None
    found = []
    for key in ("mass", "stiffness"):
        with at_key(path, f"matrices.{key}"):
            found.append(read_square(path.parent / getattr(file.matrices, key), mesh.n, mesh.dimension))
    stress = sparse.csr_array((0, mesh.n))
    if file.matrices.stress is not None:
        with at_key(path, "matrices.stress"):
            stress = read_matrix(path.parent / file.matrices.stress, mesh.n, mesh.dimension)
            _refuse_other_points(stress.shape[0], boundary, mesh)
    elif boundary is not None and file.material is not None and file.material.poisson_ratio is not None:
        first, shear = _stress(named, element_blocks(mesh))
        by_lambda, by_mu = lame_factors(_ratio(file), _state(file, mesh))
        stress = file.material.youngs_modulus * (by_lambda * first + by_mu * shear)
    with at_key(path, "matrices"):
        return finished_parts(mesh, found[0], found[1], stress, made_with)


def _refuse_other_points(rows: int, boundary: Boundary | None, mesh: SolidMesh) -> None:
    """Refuse stress of spatial bodies that is not six numbers at each point, those of the surface if there is one."""
    if mesh.dimension == 2:
        return
    wanted = 6 * len(boundary.points) if boundary is not None else 6 * (rows // 6)
    if rows != wanted:
        raise InputError(
            f"there are {rows} rows instead of {wanted}. Give six for each point, xx, yy, zz, yz, xz and xy, in the order of the surface's "
            "nodes if there is a mesh."
        )


def _clamped(path: Path, file: BodyFile, mesh: SolidMesh) -> np.ndarray:
    """Numbers of the clamped nodes, which leave no rigid motion."""
    if file.clamp is None:
        return np.zeros(0, int)
    with at_key(path, "clamp"):
        nodes = nodes_in(mesh, file.clamp)
        held = rigid_motions((mesh.nodes[nodes] - mesh.nodes[nodes[0]]) / mesh.size)
        if np.linalg.eigvalsh(held.T @ held)[0] < AT_ONE_PLACE**2:
            where, apart = ("at one place", "edge") if mesh.dimension == 2 else ("at one place or on one line", "face")
            raise InputError(
                f"the clamp on {file.clamp.words} holds {len(nodes)} node{'s' * (len(nodes) > 1)} {where}, and the body can still turn "
                f"about it. Clamp nodes that are apart, for example a whole {apart}."
            )
        return nodes


def _ties(named: _Named, nodes: np.ndarray) -> dict[str, Tie]:
    """The interface points, where the nodes are these, real or complex for a complex step."""
    found, mesh = {}, replace(named.mesh, nodes=nodes)
    boundary = named.boundary and replace(named.boundary, nodes=nodes)
    for name, region in named.file.interface_points.items():
        with at_key(named.path, f"interface_points.{name}"):
            members = named.tied[name]
            found[name] = tie(mesh, members, spread_of(boundary, members), region.at, region.tie == "rigid")
    return found


def _pressure_surfaces(named: _Named, unmoved: SolidMesh) -> dict[str, BoundaryFaces]:
    found = {}
    for name, region in named.file.pressure_surfaces.items():
        with at_key(named.path, f"pressure_surfaces.{name}"):
            found[name] = faces_in(unmoved, named.boundary, region)
    return found
