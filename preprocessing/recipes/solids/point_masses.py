"""Concentrated masses of a mesh file as constant summands of the mass matrices of a solid.

A mass m whose place P moves with the nodes that carry it, by the rows of `basis.solids.ties`, and its tensor of inertia J about P add

    M_ab = m X_a^T X_b + sum_k Y^k_a^T Y^k_b,    Y^k = sqrt(g_k) (e_k + theta x e_k),    g_k = (J_11 + J_22 + J_33) / 2 - J_kk

with the rows X of P, its rotation theta, and the principal axes e_k of J: the second moments g_k of the mass are those of two halves of it
on both sides of P. In the plane both g_k are J_zz / 2. X and Y are rows on the nodal coordinates and on one hidden coordinate, which is one
in the undeformed shape: it makes X the undeformed place, and Y sqrt(g_k) e_k.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from preprocessing.basis.solids.ties import NARROW, rows_of_place
from preprocessing.elements.space import SPACES, Pair
from preprocessing.foreign_files.contents import PointMass
from preprocessing.mesh.solid_mesh import SolidMesh, rotations
from preprocessing.recipes.solids.named_mesh import NamedMesh
from toolkit.foundation.errors import InputError

NO_BODY = 1e-6
"""Part of the moments of inertia by which the largest may exceed the sum of the others: files round to six digits."""


class Moved(NamedTuple):
    """Weight that moves by rows of nodal coordinates."""

    weight: float
    rows: Any  # sparse (d, n)
    undeformed: np.ndarray  # (d,), where it is in the undeformed body: its place, or its arm if it only turns


def constant_masses(mesh: SolidMesh) -> dict[Pair, Any]:
    """Component masses M_ab, sparse (n + 1, n + 1), of all concentrated masses, with a hidden coordinate; complex as the nodes.

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


def _stacked(mesh: SolidMesh) -> tuple[np.ndarray, list[Any]]:
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


def _means(mesh: SolidMesh, masses: Sequence[PointMass], axis: int) -> Any:
    """Rows (p, n) of the mean displacements along an axis of the nodes that carry each mass."""
    counts = np.array([len(each.carriers) for each in masses], int)
    nodes = np.concatenate([np.zeros(0, int), *(each.carriers for each in masses)])
    entries = np.repeat(np.arange(len(masses)), counts), mesh.dimension * nodes + axis
    return sparse.coo_array((np.repeat(1 / counts, counts), entries), shape=(len(masses), mesh.n)).tocsr()


def _turning(mesh: SolidMesh) -> list[bool]:
    """Whether the rotation of its nodes moves each mass: it has an inertia, or is not at the middle of its nodes."""
    near = NARROW * mesh.size
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
    if moments.min() < -NO_BODY * np.abs(moments).max():
        raise InputError(
            f"the rotary inertia of {mass.source} is that of no body: each principal moment of inertia is at most the sum of the others, "
            "and none is negative. Give the moments about the centre of its mass, and products with the sign of the file's format."
        )
    return [(float(moment), axis) for moment, axis in zip(moments, axes.T, strict=True) if moment > 0]
