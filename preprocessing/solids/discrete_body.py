"""A body of solid elements, or of finished matrices, ready for the choice of a basis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import sparse

from preprocessing.assembly import Matrices, Parts
from preprocessing.at_key import at_key
from preprocessing.discretisation import STEP, imaginary
from preprocessing.solids.body_file import BodyFile
from preprocessing.solids.elasticity import solid_matrices
from preprocessing.solids.elements import element_blocks
from preprocessing.solids.matrix_file import read_matrix, read_nodes, read_square
from preprocessing.solids.mesh_file import read_mesh
from preprocessing.solids.node_sets import nodes_in, weights_of
from preprocessing.solids.outline import BoundaryLines, outline_of
from preprocessing.solids.parts import element_parts, finished_parts, parameters_of
from preprocessing.solids.plane_material import lame_factors
from preprocessing.solids.solid_mesh import SolidMesh, rigid_motions
from preprocessing.solids.solid_stress import stress_rows
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
    by_poisson_ratio: Mapping[str, Matrices]  # derivatives by `poisson_ratio`, if it is one
    poisson_ratio: Mapping[str, float]  # its nominal value, if it is a parameter
    clamped: np.ndarray  # numbers of nodes
    ties: Mapping[str, Tie]
    outline: BoundaryLines | None  # None without elements


def discrete_body(path: Path, file: BodyFile) -> DiscreteBody:
    """Read and assemble all that body.toml names.

    Raises
    ------
    InputError
        Names the file, the key and what is wrong there.
    """
    mesh, outline = _mesh(path, file)
    made_with = {} if file.material is None or file.section is None else {
        "youngs_modulus": file.material.youngs_modulus, "density": file.material.density, "width": file.section.width,
    }  # fmt: skip
    values = dict(parameters_of(made_with, file.damping.model_dump()))
    derivative: dict[str, Matrices] = {}
    nominal: dict[str, float] = {}
    if file.matrices is None:
        parts, stepped = _from_elements(path, file, mesh, outline)
        derivative, nominal = {"poisson_ratio": imaginary(stepped.at(values))}, {"poisson_ratio": _ratio(file)}
    else:
        parts = _from_files(path, file, mesh, outline, made_with)
    return DiscreteBody(
        mesh, parts, values, derivative, nominal, _clamped(path, file, mesh), _ties(path, file, mesh, outline), outline
    )


def _mesh(path: Path, file: BodyFile) -> tuple[SolidMesh, BoundaryLines | None]:
    if file.mesh is not None:
        with at_key(path, "mesh.file"):
            mesh = read_mesh(path.parent / file.mesh.file, file.mesh.scale)
        return mesh, outline_of(mesh.nodes, mesh.blocks)
    with at_key(path, "matrices.nodes"):
        return SolidMesh(read_nodes(path.parent / str(file.matrices and file.matrices.nodes))), None


def _ratio(file: BodyFile) -> float:
    return (file.material.poisson_ratio if file.material else None) or 0.0


def _from_elements(path: Path, file: BodyFile, mesh: SolidMesh, outline: BoundaryLines | None) -> tuple[Parts, Parts]:
    """Parts of the body, and with a complex step in Poisson's ratio."""
    assert file.material is not None
    assert outline is not None
    with at_key(path, "mesh.file"):
        blocks = element_blocks(mesh)
    matrices = solid_matrices(blocks, len(mesh.nodes), mesh.dimension)
    rows = stress_rows(file.stress.quantity, blocks, outline)
    nominal, stepped = (lame_factors(_ratio(file) + step, file.material.state) for step in (0.0, 1j * STEP))
    return element_parts(matrices, rows, nominal), element_parts(matrices, rows, stepped)


def _from_files(
    path: Path, file: BodyFile, mesh: SolidMesh, outline: BoundaryLines | None, made_with: Mapping[str, float]
) -> Parts:
    assert file.matrices is not None
    found = []
    for key in ("mass", "stiffness"):
        with at_key(path, f"matrices.{key}"):
            found.append(read_square(path.parent / getattr(file.matrices, key), mesh.n))
    stress = sparse.csr_array((0, mesh.n))
    if file.matrices.stress is not None:
        with at_key(path, "matrices.stress"):
            stress = read_matrix(path.parent / file.matrices.stress, mesh.n)
    elif outline is not None and file.material is not None and file.material.poisson_ratio is not None:
        first, shear = stress_rows(file.stress.quantity, element_blocks(mesh), outline)
        by_lambda, by_mu = lame_factors(_ratio(file), file.material.state)
        stress = file.material.youngs_modulus * (by_lambda * first + by_mu * shear)
    with at_key(path, "matrices"):
        return finished_parts(mesh, found[0], found[1], stress, made_with)


def _clamped(path: Path, file: BodyFile, mesh: SolidMesh) -> np.ndarray:
    """Numbers of the clamped nodes, which leave no rigid motion."""
    if file.clamp is None:
        return np.zeros(0, int)
    with at_key(path, "clamp"):
        nodes = nodes_in(mesh, file.clamp)
        held = rigid_motions((mesh.nodes[nodes] - mesh.nodes[nodes[0]]) / mesh.size)
        if np.linalg.eigvalsh(held.T @ held)[0] < AT_ONE_PLACE**2:
            raise InputError(
                f"the clamp on {file.clamp.words} holds {len(nodes)} node at one place, and the body can still turn about it. Clamp nodes "
                "that are apart, for example a whole edge."
            )
        return nodes


def _ties(path: Path, file: BodyFile, mesh: SolidMesh, outline: BoundaryLines | None) -> dict[str, Tie]:
    found = {}
    for name, region in file.interface_points.items():
        with at_key(path, f"interface_points.{name}"):
            nodes = nodes_in(mesh, region)
            found[name] = tie(mesh, nodes, weights_of(outline, nodes), region.at, region.tie == "rigid")
    return found
