"""The mesh of a body.toml with its regions: nodes of the clamp and of interface points, faces, and concentrated masses.

A mass m whose place P moves with the nodes that carry it, by the rows of `basis.solids.ties`, and its tensor of inertia J about P add

    M_ab = m X_a^T X_b + sum_k Y^k_a^T Y^k_b,    Y^k = sqrt(g_k) (e_k + theta x e_k),    g_k = (J_11 + J_22 + J_33) / 2 - J_kk

with the rows X of P, its rotation theta, and the principal axes e_k of J: the second moments g_k of the mass are those of two halves of it
on both sides of P. In the plane both g_k are J_zz / 2. X and Y are rows on the nodal coordinates and on one hidden coordinate, which is one
in the undeformed shape: it makes X the undeformed place, and Y sqrt(g_k) e_k.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import sparse

from preprocessing.builders.body_file import BodyFile, Region
from preprocessing.elements.elasticity import solid_matrices
from preprocessing.elements.element import SPACES, Pair
from preprocessing.elements.solid_elements import element_blocks
from preprocessing.foreign_files.contents import PointMass
from preprocessing.mesh.faces import BoundaryFaces, BoundaryLines, faces_of, outline_of
from preprocessing.mesh.input_files import at_key
from preprocessing.mesh.matrix_file import read_motion, read_nodes
from preprocessing.mesh.mesh_file import read_mesh
from preprocessing.mesh.solid_mesh import SolidMesh, rigid_motions, rotations
from preprocessing.reduction.ties import ONE_POINT_RADIUS, NodeTie, rows_of_place, tie
from toolkit.foundation.errors import InputError, meant

BOX_TOLERANCE = 1e-9
"""Part of the body's extent by which a node may be outside of a box."""


Boundary = BoundaryLines | BoundaryFaces
"""The boundary of a mesh in the plane, or in space."""


def nodes_in(mesh: SolidMesh, region: Region) -> np.ndarray:
    """Numbers of the nodes of a region, in order.

    Raises
    ------
    InputError
        The group is unknown, a number too high, or the region is empty.
    """
    if region.group is not None:
        found = _of_group(mesh, region.group)
    elif region.box is not None:
        found = _in_box(mesh, region.box)
    else:
        found = _numbered(mesh, np.unique(np.asarray(region.nodes, int)))
    if not len(found):
        raise InputError(f"{region.words} holds no node of the elements. Choose another group, or a larger box.")
    return found


def _numbered(mesh: SolidMesh, wanted: np.ndarray) -> np.ndarray:
    """Nodes by their numbers in the file."""
    known = np.arange(len(mesh.nodes)) if mesh.in_file is None else mesh.in_file
    if lacking := wanted[~np.isin(wanted, known)].tolist():
        raise InputError(
            f"no element has node {lacking[0]}; the nodes of the elements count from {known[0]} to {known[-1]}, from 0 in the file."
        )
    return np.searchsorted(known, wanted)


def _of_group(mesh: SolidMesh, group: str) -> np.ndarray:
    if group not in mesh.groups:
        raise InputError(
            f"the mesh has no group {group!r}{meant(group, mesh.groups)}; there are {', '.join(map(repr, mesh.groups)) or 'none'}. Name "
            "one of them, or take a box or numbers of nodes."
        )
    return mesh.groups[group]


def _in_box(mesh: SolidMesh, box: list[float]) -> np.ndarray:
    axes = "xyz"[: mesh.dimension]
    order = ", ".join(f"{axis}_{end}" for end in ("min", "max") for axis in axes)
    if len(box) != 2 * mesh.dimension:
        raise InputError(f"the box {box} has {len(box)} numbers, but the body has {mesh.dimension} axes; write {order}.")
    low, high = np.array(box).reshape(2, -1)
    if np.any(low > high):
        raise InputError(f"the box {box} is turned inside out; write {order}.")
    slack = BOX_TOLERANCE * mesh.size
    return np.flatnonzero(np.all((mesh.nodes >= low - slack) & (mesh.nodes <= high + slack), axis=1))


def spread_of(mesh: SolidMesh, boundary: Boundary | None, nodes: np.ndarray) -> sparse.sparray:
    """Weights W (k, k) of means sum_kl W_kl f_k g_l over the nodes; the sum of all is 1.

    Where the nodes are those of whole elements, the mean is that over these elements, int f g dV / V; where every node is on an edge or
    face of the boundary between these nodes, that over the boundary, int f g dA / A: so it does not depend on the mesh. Else all nodes
    count alike.
    """
    for products in (_over_elements(mesh, nodes), None if boundary is None else boundary.between(nodes).products()):
        if products is not None:
            here = products[nodes][:, nodes]
            if np.all(here.diagonal().real > 0):
                return here / here.sum()
    return sparse.diags_array(np.full(len(nodes), 1 / len(nodes)), format="csr")


def _over_elements(mesh: SolidMesh, nodes: np.ndarray) -> sparse.csr_array | None:
    """Integrals int N_k N_l dV over elements between these nodes, (n_nodes, n_nodes); None where there are none.

    The nodes of the mesh may carry a complex step, along which the integral has its derivative.
    """
    inside = {kind: block[np.isin(block, nodes).all(axis=1)] for kind, block in mesh.blocks.items()}
    inside = {kind: block for kind, block in inside.items() if len(block)}
    if not inside:
        return None
    blocks = element_blocks(SolidMesh(mesh.nodes.real, inside))
    found = solid_matrices(blocks, len(mesh.nodes), mesh.dimension).scalar_mass
    if not np.iscomplexobj(mesh.nodes):
        return found
    return found + 1j * solid_matrices(blocks, len(mesh.nodes), mesh.dimension, mesh.nodes.imag).scalar_mass


def faces_in(mesh: SolidMesh, surface: BoundaryFaces, region: Region) -> BoundaryFaces:
    """Faces of the surface that a region means: those of the group, or all between its nodes.

    Raises
    ------
    InputError
        See `nodes_in`; or no face of the surface is there.
    """
    nodes = nodes_in(mesh, region)
    group = mesh.faces.get(region.group or "")
    found = surface.named(group) if group else surface.between(nodes)
    if not any(len(each) for each in found.faces.values()):
        raise InputError(
            f"{region.words} holds no whole face of the body's surface. Name a group of faces, or all nodes of some faces."
        )
    return found


SAME_PLACE = 1e-6
"""Distance of clamped nodes, in parts of the body's extent, below which they leave the body free to turn."""


@dataclass(frozen=True, eq=False)
class NamedMesh:
    """Mesh that body.toml names, and the nodes of its regions, chosen before shape variables move it."""

    path: Path
    file: BodyFile
    mesh: SolidMesh
    boundary: Boundary | None  # None without elements
    clamped: np.ndarray
    tied: Mapping[str, np.ndarray]  # interface point -> nodes
    surfaces: Mapping[str, BoundaryFaces]  # pressure surfaces
    motions: Mapping[str, np.ndarray]  # shape variable -> displacement of the nodes per unit of it, (n_nodes, d)

    def ties(self, nodes: np.ndarray) -> dict[str, NodeTie]:
        """Interface points, with the nodes at (n_nodes, d), real or complex for a complex step.

        Raises
        ------
        InputError
            The nodes of a point tell no rotation, see `ties.tie`.
        """
        found, mesh = {}, replace(self.mesh, nodes=nodes)
        boundary = self.boundary and replace(self.boundary, nodes=nodes)
        for name, region in self.file.interface_points.items():
            with at_key(self.path, f"interface_points.{name}"):
                members = self.tied[name]
                found[name] = tie(mesh, members, spread_of(mesh, boundary, members), region.at, region.tie == "rigid")
        return found


def named_mesh(path: Path, file: BodyFile) -> NamedMesh:
    """Mesh or nodes that body.toml names, with everything that is named on them.

    Raises
    ------
    InputError
        Names the file, the key and what is wrong there.
    """
    unmoved, mesh, motions = _mesh(path, file)
    _refuse_other_dimension(path, file, mesh)
    with at_key(path, "mesh.file"):
        boundary = _boundary(mesh)
    surfaces = {}
    for name, region in file.pressure_surfaces.items():
        with at_key(path, f"pressure_surfaces.{name}"):
            assert isinstance(boundary, BoundaryFaces)
            surfaces[name] = faces_in(unmoved, boundary, region)
    return NamedMesh(path, file, mesh, boundary, _clamped(path, file, unmoved), _tied(path, file, unmoved), surfaces, motions)


def _mesh(path: Path, file: BodyFile) -> tuple[SolidMesh, SolidMesh, dict[str, np.ndarray]]:
    """The mesh of the file, the mesh at the values of the shape variables, and the motion of its nodes by each of them."""
    if file.mesh is None:
        with at_key(path, "matrices.nodes"):
            mesh = SolidMesh(read_nodes(path.parent / str(file.matrices and file.matrices.nodes)))
            return mesh, mesh, {}
    with at_key(path, "mesh.file"):
        unmoved = mesh = read_mesh(path.parent / file.mesh.file, file.mesh.scale, file.mesh.leave_out)
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
            mesh = mesh.moved(variable.value * motions[name])
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


def _tied(path: Path, file: BodyFile, mesh: SolidMesh) -> dict[str, np.ndarray]:
    """Nodes of every interface point."""
    tied = {}
    for name, region in file.interface_points.items():
        with at_key(path, f"interface_points.{name}"):
            tied[name] = nodes_in(mesh, region)
    return tied


def _clamped(path: Path, file: BodyFile, mesh: SolidMesh) -> np.ndarray:
    """Numbers of the clamped nodes, which leave no rigid motion."""
    if file.clamp is None:
        return np.zeros(0, int)
    with at_key(path, "clamp"):
        nodes = nodes_in(mesh, file.clamp)
        held = rigid_motions((mesh.nodes[nodes] - mesh.nodes[nodes[0]]) / mesh.size)
        if np.linalg.eigvalsh(held.T @ held)[0] < SAME_PLACE**2:
            where, apart = ("at one place", "edge") if mesh.dimension == 2 else ("at one place or on one line", "face")
            raise InputError(
                f"the clamp on {file.clamp.words} holds {len(nodes)} node{'s' * (len(nodes) > 1)} {where}, and the body can still turn "
                f"about it. Clamp nodes that are apart, for example a whole {apart}."
            )
        return nodes


MOMENT_TOLERANCE = 1e-6
"""Part of the moments of inertia by which the largest may exceed the sum of the others: files round to six digits."""


class Moved(NamedTuple):
    """Weight that moves by rows of nodal coordinates."""

    weight: float
    rows: sparse.csr_array  # (d, n)
    undeformed: np.ndarray  # (d,), where it is in the undeformed body: its place, or its arm if it only turns


def constant_masses(mesh: SolidMesh) -> dict[Pair, sparse.csr_array]:
    """Component masses M_ab (n + 1, n + 1), of all concentrated masses, with a hidden coordinate; complex as the nodes.

    Raises
    ------
    InputError
        A mass has an inertia that no body has, or needs a rotation of nodes that tell none; names its source.
    """
    weight, axes = _stacked(mesh)
    weighted = sparse.diags_array(weight, format="csr")
    return {(a, b): (axes[a].T @ weighted @ axes[b]).tocsr() for a, b in SPACES[mesh.dimension].pairs}


def at_nodes(mesh: SolidMesh) -> bool:
    """Whether every mass is at one node, and does not turn."""
    return not any(turns or len(each.carriers) > 1 for each, turns in zip(mesh.masses, _turning(mesh), strict=True))


def remarks_on_masses(named: NamedMesh) -> Iterator[str]:
    """Sentences on concentrated masses that are treated otherwise than by the program that wrote them."""
    mesh, file = named.mesh, named.file
    if not mesh.masses:
        return
    if file.mesh and file.mesh.scale != 1:
        total = sum(each.mass for each in mesh.masses)
        yield f"the concentrated masses of the mesh file, {total:g} in all, count in the unit of body.toml: scale is that of lengths alone."
    if file.matrices:
        yield "the mass matrix is taken to hold the concentrated masses of the mesh file already."
    rigid = [named.clamped, *(nodes for name, nodes in named.tied.items() if file.interface_points[name].tie == "rigid")]
    for each, turns in zip(mesh.masses, _turning(mesh), strict=True):
        yield from _remarks(mesh, each, turns, rigid)


def _remarks(mesh: SolidMesh, mass: PointMass, turns: bool, rigid: Sequence[np.ndarray]) -> Iterator[str]:
    """Remarks on one mass; `rigid` are the nodes of the clamp and of each rigid tie."""
    if mass.rigid and len(mass.carriers) > 1 and not any(np.isin(mass.carriers, nodes).all() for nodes in rigid):
        yield (
            f"the concentrated mass of {mass.source} is on a rigid body in the mesh file; its nodes stay elastic here, and it moves with "
            'their mean. Tie them by an interface point with tie = "rigid" to make them rigid.'
        )
    if not mass.rigid and len(mass.carriers) > 1:
        yield f"the concentrated mass of {mass.source} moves with the mean of {len(mass.carriers)} nodes, which all count alike."
    if len(mass.carriers) == 1 and turns:
        yield (
            f"the concentrated mass of {mass.source} has an offset or a rotary inertia at a node that has no rotation of its own; it "
            "turns with the nodes around that."
        )
    if mesh.dimension == 2 and np.any(np.delete(mass.inertia, 2)):
        yield f"of the rotary inertia of {mass.source} only that about z counts in the plane."


def _stacked(mesh: SolidMesh) -> tuple[np.ndarray, list[sparse.csr_array]]:
    """Weights (p,), and for each axis the rows (p, n + 1) of all weights, with the hidden coordinate."""
    every = [*zip(mesh.masses, _turning(mesh), strict=True)]
    still = [mass for mass, turns in every if not turns]
    moved = [each for mass, turns in every if turns for each in _of_turning(mesh, mass)]
    xi = mesh.nodes.ravel()
    fixed = [each.undeformed - each.rows @ xi for each in moved]
    axes = []
    for axis in range(mesh.dimension):
        rows = sparse.vstack([_means(mesh, still, axis), *(each.rows[[axis]] for each in moved)])
        hidden = sparse.csr_array(np.array([0.0] * len(still) + [each[axis] for each in fixed]).reshape(-1, 1))
        axes.append(sparse.hstack([rows, hidden], format="csr"))
    return np.array([each.mass for each in still] + [each.weight for each in moved]), axes


def _means(mesh: SolidMesh, masses: Sequence[PointMass], axis: int) -> sparse.csr_array:
    """Rows (p, n) of the mean displacements along an axis of the nodes that carry each mass."""
    counts = np.array([len(each.carriers) for each in masses], int)
    nodes = np.concatenate([np.zeros(0, int), *(each.carriers for each in masses)])
    entries = np.repeat(np.arange(len(masses)), counts), mesh.dimension * nodes + axis
    return sparse.coo_array((np.repeat(1 / counts, counts), entries), shape=(len(masses), mesh.n)).tocsr()


def _turning(mesh: SolidMesh) -> list[bool]:
    """Whether the rotation of its nodes moves each mass: it has an inertia, or is not at the middle of its nodes."""
    near = ONE_POINT_RADIUS * mesh.size
    arms = (np.real(_place(mesh, each) - mesh.nodes[each.carriers].mean(axis=0)) for each in mesh.masses)
    return [
        bool(np.abs(arm).max() > near or np.any(_own_inertia(mesh, each))) for each, arm in zip(mesh.masses, arms, strict=True)
    ]


def _place(mesh: SolidMesh, mass: PointMass) -> np.ndarray:
    return np.array(mass.place[: mesh.dimension])


def _own_inertia(mesh: SolidMesh, mass: PointMass) -> tuple[float, ...]:
    """Entries of a mass's inertia that turn in the plane, or in space."""
    return (mass.inertia[2],) if mesh.dimension == 2 else mass.inertia


def _of_turning(mesh: SolidMesh, mass: PointMass) -> Iterator[Moved]:
    """Weights of a mass at its place that turns with its nodes, and of those that stand for its inertia."""
    d, place = mesh.dimension, _place(mesh, mass)
    try:
        rows = rows_of_place(mesh, mass.carriers, place)
    except InputError as error:
        raise InputError(
            f"the concentrated mass of {mass.source} cannot turn with its nodes: {error} Or leave it out: leave_out in [mesh]."
        ) from error
    yield Moved(mass.mass, rows[:d], place)
    for moment, axis in _principal(mesh, mass):
        yield Moved(moment, sparse.csr_array(rotations(axis).T) @ rows[d:], axis)


def _principal(mesh: SolidMesh, mass: PointMass) -> Sequence[tuple[float, np.ndarray]]:
    """Second moments g_k of its mass, those that are not zero, and the axes e_k along which they are."""
    xx, yy, zz, xy, xz, yz = mass.inertia
    if mesh.dimension == 2:
        moments, axes = np.full(2, zz / 2), np.eye(2)
    else:
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        moments, axes = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    if moments.min() < -MOMENT_TOLERANCE * np.abs(moments).max():
        raise InputError(
            f"the rotary inertia of {mass.source} is that of no body: each principal moment of inertia is at most the sum of the others, "
            "and none is negative. Give the moments about the centre of its mass, and products with the sign of the file's format."
        )
    return [(float(moment), axis) for moment, axis in zip(moments, axes.T, strict=True) if moment > 0]
