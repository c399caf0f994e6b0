"""A body of solid elements, or of finished matrices, ready for the choice of a basis."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import TypeVar

import numpy as np
from scipy import sparse

from preprocessing.builders.body_file import BodyFile, MatricesTable
from preprocessing.builders.named_mesh import Boundary, NamedMesh, at_nodes, constant_masses, named_mesh
from preprocessing.elements.elasticity import SolidMatrices, StressedSolid, solid_matrices
from preprocessing.elements.element import Pair
from preprocessing.elements.solid import Solid, element_solid, finished_solid, parameters_of
from preprocessing.elements.solid_elements import ElementBlock, element_blocks
from preprocessing.elements.stress import Elastic, Rows, stress_rows
from preprocessing.elements.uniform_material import (
    UniformMaterial,
    refuse_other_mass,
    refuse_other_stiffness,
    scalar_mass,
    volume_of,
    volume_of_mass,
    without_constant,
)
from preprocessing.mesh.faces import BoundaryFaces
from preprocessing.mesh.input_files import at_key
from preprocessing.mesh.matrix_file import read_matrix, square_of
from preprocessing.mesh.overlaps import refuse_overlaps
from preprocessing.mesh.solid_mesh import SolidMesh
from preprocessing.reduction.assembly import Parts, assemble
from preprocessing.reduction.body_change import BodyChange
from preprocessing.reduction.discretisation import STEP, derivative_of
from preprocessing.reduction.ties import NodeTie
from toolkit.foundation.errors import InputError


@dataclass(frozen=True, eq=False)
class DiscreteBody:
    """Body as finite elements, before the choice of a basis."""

    mesh: SolidMesh
    parts: Parts
    values: Mapping[str, float]  # parameters by which the matrices are polynomials
    others: Mapping[str, float]  # the other parameters, and their nominal values
    changes: Iterable[
        tuple[str, BodyChange]
    ]  # what each of these changes, to be asked for once: of large bodies one fits in memory
    clamped: np.ndarray  # numbers of nodes
    ties: Mapping[str, NodeTie]
    boundary: Boundary | None  # None without elements
    pressure_surfaces: Mapping[str, BoundaryFaces]
    elastic: Elastic | None = None  # None without elements that were assembled here
    element: Solid | None = None


def discrete_body(path: Path, file: BodyFile) -> DiscreteBody:
    """Read and assemble all that body.toml names.

    Raises
    ------
    InputError
        Names the file, the key and what is wrong there.
    """
    return discretised(named_mesh(path, file))


def discretised(named: NamedMesh) -> DiscreteBody:
    """Assemble a body of a mesh that was read; raises as `discrete_body`."""
    file, mesh = named.file, named.mesh
    material, section = file.material, file.section
    made_with = {} if material is None else {"youngs_modulus": material.youngs_modulus, "density": material.density}
    if file.matrices is not None and file.matrices.mass_differs:
        made_with = {"youngs_modulus": made_with["youngs_modulus"], "mass_scale": 1.0}
    made_with |= {} if section is None else {"width": section.width}
    values = dict(parameters_of(made_with, file.damping.model_dump()))
    ties = named.ties(mesh.nodes)
    others: dict[str, float] = {}
    changes: Iterable[tuple[str, BodyChange]] = ()
    elastic = None
    if file.matrices is None:
        others = {"poisson_ratio": _ratio(file), **{name: variable.value for name, variable in file.shape_variables.items()}}
        solid, changes, elastic = _from_elements(named, values, ties)
    else:
        solid, remarks = _from_files(named, made_with)
        mesh = replace(mesh, remarks=(*mesh.remarks, *remarks))
    parts = assemble(solid)
    changes = chain(changes, _beside_masses(parts, named, values, ties, solid.stressed))
    return DiscreteBody(mesh, parts, values, others, changes, named.clamped, ties, named.boundary, named.surfaces, elastic, solid)


def _ratio(file: BodyFile) -> float:
    return (file.material.poisson_ratio if file.material else None) or 0.0


def _state(file: BodyFile, mesh: SolidMesh) -> str:
    return "space" if mesh.dimension == 3 else (file.material and file.material.state) or "plane-stress"


def _stress(named: NamedMesh, blocks: list[ElementBlock], motion: np.ndarray | None = None) -> Rows:
    assert named.boundary is not None
    with at_key(named.path, "stress.quantity"):
        return stress_rows(named.file.stress.quantity, blocks, named.boundary, motion)


def _from_elements(
    named: NamedMesh, values: Mapping[str, float], ties: Mapping[str, NodeTie]
) -> tuple[Solid, Iterator[tuple[str, BodyChange]], Elastic]:
    """Elements of the body, changes by Poisson's ratio and shape variables, and the elements that judge the stress."""
    mesh, ratio, state = named.mesh, _ratio(named.file), _state(named.file, named.mesh)
    with at_key(named.path, "mesh.file"):
        blocks = element_blocks(mesh)
        refuse_overlaps(mesh)
    matrices, rows = solid_matrices(blocks, len(mesh.nodes), mesh.dimension), _stress(named, blocks)
    lame = lame_factors(ratio, state)
    stepped_lame = lame_factors(ratio + 1j * STEP, state)
    slopes = stepped_lame[0].imag / STEP, stepped_lame[1].imag / STEP
    with at_key(named.path, "mesh.file"):
        masses = constant_masses(mesh) if mesh.masses else None
    no_masses = None if masses is None else {pair: 0 * matrix for pair, matrix in masses.items()}
    weightless = SolidMatrices(sparse.csr_array(matrices.scalar_mass.shape), matrices.first, matrices.shear)
    of_ratio = assemble(element_solid(mesh.nodes, weightless, rows, slopes, None, no_masses))
    stepped = StressedSolid(blocks, stepped_lame)
    changes = _changes(of_ratio, named, blocks, lame, values, ties, stepped)
    elastic = Elastic(blocks, mesh.nodes, lame, ratio if state == "plane-strain" else 0.0)
    return element_solid(mesh.nodes, matrices, rows, lame, StressedSolid(blocks, lame), masses), changes, elastic


def _changes(
    of_ratio: Parts,
    named: NamedMesh,
    blocks: list[ElementBlock],
    lame: tuple[float, float],
    values: Mapping[str, float],
    ties: Mapping[str, NodeTie],
    stepped: StressedSolid,
) -> Iterator[tuple[str, BodyChange]]:
    """Changes by Poisson's ratio, of which there is a solid with a complex step, and by the motions, one after the other."""
    normals = {
        name: faces.normals() for name, faces in named.surfaces.items()
    }  # the shapes that a pressure moves follow the ratio
    yield "poisson_ratio", BodyChange(of_ratio.at(values), named.mesh, ties, normals, stepped)
    del of_ratio
    for name, motion in named.motions.items():
        yield name, _moved(named, blocks, motion, lame, values)


def _moved(
    named: NamedMesh, blocks: list[ElementBlock], motion: np.ndarray, lame: tuple[float, float], values: Mapping[str, float]
) -> BodyChange:
    """Change of the body by a motion of the nodes."""
    mesh = named.mesh
    own = solid_matrices(blocks, len(mesh.nodes), mesh.dimension, motion)
    moved = mesh.moved(1j * STEP * motion)
    masses = {pair: derivative_of(matrix) for pair, matrix in constant_masses(moved).items()} if mesh.masses else None
    rates = assemble(element_solid(mesh.nodes, own, _stress(named, blocks, motion), lame, None, masses)).at(values)
    normals = {key: BoundaryFaces(moved.nodes, each.faces).normals() for key, each in named.surfaces.items()}
    return BodyChange(rates, moved, named.ties(moved.nodes), normals, StressedSolid(blocks, lame, STEP * motion))


def _beside_masses(
    parts: Parts, named: NamedMesh, values: Mapping[str, float], ties: Mapping[str, NodeTie], stressed: StressedSolid | None
) -> Iterator[tuple[str, BodyChange]]:
    """Changes of a body with concentrated masses by density and width p, which its shapes follow.

    Polynomials tell what these change of the matrices. With K and the rest of M in proportion to p, its shapes see -M_c / p: that the
    masses M_c become lighter beside the rest.
    """
    constant = parts.constant_mass
    if not constant.parts:
        return
    normals = {name: faces.normals() for name, faces in named.surfaces.items()}
    mass = parts.coordinates.of_nodes(constant.at(values).mass)
    for name in ("density", "width"):
        if name in values:
            yield name, BodyChange(parts.none.at(values), named.mesh, ties, normals, stressed, -mass / values[name])


def _from_files(named: NamedMesh, made_with: Mapping[str, float]) -> tuple[Solid, list[str]]:
    """Body of finished matrices, and remarks on how they were read."""
    path, file, mesh = named.path, named.file, named.mesh
    assert file.matrices is not None
    found = []
    for key in ("mass", "stiffness"):
        with at_key(path, f"matrices.{key}"):
            found.append(_square(path, file.matrices, getattr(file.matrices, key), mesh))
    (mass, of_mass), (stiffness, of_stiffness) = found
    blocks = []
    if file.material is not None and mesh.blocks:
        with at_key(path, "mesh.file"):
            blocks = element_blocks(mesh)
    stress = _finished_stress(named, blocks)
    with at_key(path, "matrices"):
        solid = finished_solid(mesh, mass, stiffness, stress, made_with, _among_finished(mesh))
        _compare(named, blocks, mass, stiffness)
    return solid, [*dict.fromkeys(remark for remark in (of_mass, of_stiffness) if remark)]


def _finished_stress(named: NamedMesh, blocks: list[ElementBlock]) -> sparse.csr_array:
    """Stress per nodal displacement, from its file, or from the elements where there are both these and their material."""
    path, file, mesh = named.path, named.file, named.mesh
    if file.matrices is not None and file.matrices.stress is not None:
        with at_key(path, "matrices.stress"):
            stress = read_matrix(path.parent / file.matrices.stress, mesh.n, mesh.dimension)
            _refuse_other_points(stress.shape[0], named.boundary, mesh)
        return stress
    if not blocks or file.material is None or file.material.poisson_ratio is None:
        return sparse.csr_array((0, mesh.n))
    first, shear = _stress(named, blocks)
    by_lambda, by_mu = lame_factors(_ratio(file), _state(file, mesh))
    return file.material.youngs_modulus * (by_lambda * first + by_mu * shear)


def _among_finished(mesh: SolidMesh) -> dict[Pair, sparse.csr_array] | None:
    """Concentrated masses of the mesh, which another program's mass matrix holds already; None if there are none."""
    if not mesh.masses:
        return None
    if not at_nodes(mesh):
        raise InputError(
            "the mesh has concentrated masses with an offset, a rotary inertia or several nodes, and of these the mass matrix cannot tell "
            "what it holds. Leave them out of the mesh: leave_out in [mesh]; then all of the matrix follows the density."
        )
    return constant_masses(mesh)


def _square(path: Path, matrices: MatricesTable, name: str, mesh: SolidMesh) -> tuple[sparse.csr_array, str]:
    """Mass or stiffness matrix in the order of the mesh's nodes, and a remark."""
    degrees = matrices.degrees_of(name)
    if degrees is not None and matrices.dof is None and not (path.parent / degrees).exists():
        raise InputError(
            f"CalculiX writes {degrees!r} beside {name!r}, which says what its rows are, and it is not there. Put it there, or name it: "
            "matrices.dof."
        )
    return square_of(
        path.parent / name, len(mesh.nodes), mesh.dimension, mesh.labels, None if degrees is None else path.parent / degrees
    )


def _compare(named: NamedMesh, blocks: list[ElementBlock], mass: sparse.csr_array, stiffness: sparse.csr_array) -> None:
    """Refuse matrices that are not those of the material, in the elements of the mesh where there is one."""
    file, mesh, given = named.file, named.mesh, named.file.material
    if given is None or file.matrices is None or (file.matrices.mass_differs and not blocks):
        return
    state, scalar = _state(file, mesh), scalar_mass(mass, mesh.dimension)
    if mesh.masses and not file.matrices.mass_differs:
        scalar = without_constant(scalar, constant_masses(mesh), mesh)
    lame = None if given.poisson_ratio is None else lame_factors(given.poisson_ratio, state)
    width = file.section.width if file.section else 1.0
    material = UniformMaterial(given.youngs_modulus, given.density, lame, width, state)
    volume = volume_of(blocks) if blocks else volume_of_mass(mesh, scalar, material)
    if blocks:
        refuse_other_mass(mesh, scalar, material, volume, file.matrices.mass_differs)
    refuse_other_stiffness(mesh, stiffness, material, volume)


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


Ratio = TypeVar("Ratio", float, complex)
"""Poisson's ratio nu and what follows from it: real, or complex for a complex step in nu."""


def lame_factors(poisson_ratio: Ratio, state: str) -> tuple[Ratio, Ratio]:
    """Lame factors lambda / E and mu / E.

        mu / E = 1 / (2 (1 + nu)),   lambda / E = nu / ((1 + nu) (1 - 2 nu)), or nu / (1 - nu^2) in plane stress

    The first form of lambda is that of space and of plane strain; the second makes the stress across the plane vanish.
    """
    shear = 1 / (2 * (1 + poisson_ratio))
    if state == "plane-stress":
        return poisson_ratio / (1 - poisson_ratio**2), shear
    return poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio)), shear
