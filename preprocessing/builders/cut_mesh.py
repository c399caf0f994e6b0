"""Where the pieces of a body meet and end, and these pieces as meshes of their own that nothing holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from preprocessing.builders.body_file import TiedRegion
from preprocessing.builders.discrete_body import DiscreteBody, discretised
from preprocessing.builders.named_mesh import NamedMesh
from preprocessing.foreign_files.contents import PointMass
from preprocessing.mesh.faces import BoundaryFaces, faces_of
from preprocessing.mesh.input_files import at_key
from preprocessing.mesh.solid_mesh import SolidMesh, lumps
from toolkit.foundation.errors import InputError, meant


def groups_of_elements(mesh: SolidMesh, groups: list[str]) -> dict[str, Mapping[str, np.ndarray]]:
    """Group -> its elements by kind, as `SolidMesh.blocks`.

    Raises
    ------
    InputError
        Groups are unknown, few, without elements or in lumps, or elements are in none or in two; says what is wrong where.
    """
    _refuse_groups(mesh, groups)
    blocks = {group: mesh.volumes[group] for group in groups}
    _refuse_uncovered(mesh, blocks)
    for group, each in blocks.items():
        _refuse_apart(mesh, group, each)
    return blocks


def count_of_lumps(mesh: SolidMesh, members: list[np.ndarray]) -> int:
    """Number of lumps that some elements or faces fall into."""
    return len(np.unique(lumps(len(mesh.nodes), members)[np.concatenate([each.ravel() for each in members])]))


def _refuse_groups(mesh: SolidMesh, groups: list[str]) -> None:
    known = ", ".join(map(repr, mesh.volumes)) or "none"
    for group in groups:
        if group not in mesh.volumes:
            what = "has no elements of the volume" if group in mesh.groups else "is not in the mesh"
            raise InputError(
                f"group {group!r} {what}{meant(group, mesh.volumes)}; groups with such elements: {known}. Name some of these (gmsh: "
                "Physical Volume)."
            )
    if len(set(groups)) < len(groups) or len(groups) < 2:
        raise InputError(
            f"a body is cut into two different groups at least, and here are {', '.join(map(repr, groups))}; there are {known}. Leave "
            "[pieces] out for a body of one frame."
        )


def _refuse_uncovered(mesh: SolidMesh, blocks: Mapping[str, Mapping[str, np.ndarray]]) -> None:
    """Refuse elements that are in no group, or in two."""
    for kind, every in mesh.blocks.items():
        listed = [each[kind] for each in blocks.values() if kind in each]
        found = np.concatenate([np.zeros((0, every.shape[1]), int), *listed])
        _, first, count = np.unique(np.sort(np.vstack([every, found]), axis=1), axis=0, return_index=True, return_counts=True)
        for wrong, what in ((count < 2, "no group"), (count > 2, "more than one group")):
            if np.any(wrong):
                place = ", ".join(f"{x:.4g}" for x in mesh.nodes[every[first[wrong].min()]].mean(axis=0))
                raise InputError(
                    f"{np.count_nonzero(wrong)} elements are in {what} of {', '.join(map(repr, blocks))}, the first round ({place}). Let "
                    "every element be in one of them."
                )


def _refuse_apart(mesh: SolidMesh, group: str, blocks: Mapping[str, np.ndarray]) -> None:
    count = count_of_lumps(mesh, [*blocks.values()])
    if count > 1:
        raise InputError(f"group {group!r} consists of {count} lumps that share no nodes. Make a group of each.")


class End(NamedTuple):
    """End of pieces: nodes that move with one point, where pieces begin, meet or end."""

    what: str  # for people
    nodes: np.ndarray  # numbers in the mesh
    region: TiedRegion  # how they are tied to the point, and where it is
    point: str  # interface point of the body that it is; empty if it is none


class MeshPiece(NamedTuple):
    """The elements of one group, and the two ends of the body that they reach."""

    group: str
    blocks: Mapping[str, np.ndarray]  # kind -> (n_e, nodes of one element), in the numbers of the mesh
    nodes: np.ndarray  # numbers in the mesh, rising
    ends: tuple[int, int]
    masses: list[PointMass]  # that are carried by its nodes, in the numbers of these


class CutMesh(NamedTuple):
    """Mesh cut into pieces: the ends in the order of the chain, the clamp first, and the pieces between them."""

    named: NamedMesh
    ends: list[End]
    pieces: list[MeshPiece]


def cut_mesh(named: NamedMesh) -> CutMesh:
    """Mesh cut into a chain of pieces.

    Raises
    ------
    InputError
        As of `groups_of_elements`, or the pieces are no chain from the clamp to an interface point; says what is wrong where.
    """
    mesh, table = named.mesh, named.file.pieces
    assert table is not None
    if mesh.dimension == 2:
        raise InputError("pieces are cut out of spatial meshes. Leave [pieces] out, or mesh a volume.")
    blocks = groups_of_elements(mesh, table.groups)
    nodes = {group: _nodes_of(each) for group, each in blocks.items()}
    ends = _ends(named, blocks, nodes)
    reached = {group: [k for k, end in enumerate(ends) if np.isin(end.nodes, nodes[group]).all()] for group in table.groups}
    order, groups = _walk(ends, reached)
    masses = _masses(mesh, nodes, groups)
    pieces = [MeshPiece(group, blocks[group], nodes[group], (k, k + 1), masses[group]) for k, group in enumerate(groups)]
    return CutMesh(named, [ends[k] for k in order], pieces)


def _masses(mesh: SolidMesh, nodes: Mapping[str, np.ndarray], groups: list[str]) -> dict[str, list[PointMass]]:
    """Group -> the concentrated masses of the first piece that has all nodes of each."""
    found: dict[str, list[PointMass]] = {group: [] for group in groups}
    for each in mesh.masses:
        own = [group for group in groups if np.isin(each.carriers, nodes[group]).all()]
        if not own:
            raise InputError(
                f"the concentrated mass of {each.source} is carried by nodes of several pieces. Carry it by nodes of one of them, or of a "
                "face between two."
            )
        found[own[0]].append(each._replace(carriers=np.searchsorted(nodes[own[0]], each.carriers)))
    return found


def _nodes_of(blocks: Mapping[str, np.ndarray]) -> np.ndarray:
    return np.unique(np.concatenate([each.ravel() for each in blocks.values()]))


def _ends(named: NamedMesh, blocks: Mapping[str, Mapping[str, np.ndarray]], nodes: Mapping[str, np.ndarray]) -> list[End]:
    """The clamp, the faces between pieces, and interface points elsewhere."""
    file = named.file
    assert file.pieces is not None
    places = {"the clamp": named.clamped}
    for one, other in combinations(nodes, 2):
        shared = np.intersect1d(nodes[one], nodes[other])
        if len(shared):
            _refuse_no_face(named.mesh, (one, other), faces_of(named.mesh.nodes, blocks[one]).between(shared))
            places[f"the face between {one!r} and {other!r}"] = shared
    found, left = [], dict(named.tied)
    for what, members in places.items():
        mine = [name for name, own in left.items() if np.array_equal(own, members)]
        if len(mine) > 1:
            raise InputError(
                f"interface points {mine[0]!r} and {mine[1]!r} are at the same nodes, {what}. Leave one of them out."
            )
        tie = "rigid" if what == "the clamp" else file.pieces.faces
        region = file.interface_points[mine[0]] if mine else TiedRegion(nodes=members.tolist(), tie=tie)
        region = region.model_copy(update={"tie": "rigid"}) if what == "the clamp" else region
        found.append(End(what, members, region, mine[0] if mine else ""))
        left = {name: own for name, own in left.items() if name not in mine}
    _refuse_shared(places, left, nodes)
    return found + [End(f"interface point {name!r}", own, file.interface_points[name], name) for name, own in left.items()]


def _refuse_no_face(mesh: SolidMesh, groups: tuple[str, str], faces: BoundaryFaces) -> None:
    """Refuse groups that meet in an edge or in several faces."""
    members = [each for each in faces.faces.values() if len(each)]
    count = count_of_lumps(mesh, members) if members else 0
    if count != 1:
        where = f"in {count} faces" if count else "in nodes, but in no whole face of an element,"
        raise InputError(
            f"groups {groups[0]!r} and {groups[1]!r} meet {where} and not in one. Cut the body across, into a chain."
        )


def _refuse_shared(places: Mapping[str, np.ndarray], points: Mapping[str, np.ndarray], nodes: Mapping[str, np.ndarray]) -> None:
    """Refuse faces that share nodes, and interface points that are on one of them in part, or in no piece as a whole."""
    for (one, mine), (other, theirs) in combinations(
        {**places, **{f"interface point {n!r}": p for n, p in points.items()}}.items(), 2
    ):
        if len(np.intersect1d(mine, theirs)):
            raise InputError(
                f"{one} and {other} share nodes, but not all of them. Cut the body so that they are apart, or name the same nodes."
            )
    for name, own in points.items():
        if not any(np.isin(own, each).all() for each in nodes.values()):
            raise InputError(
                f"interface point {name!r} has nodes in several pieces. Name nodes of one of them, or a face between two."
            )


def _walk(ends: list[End], reached: Mapping[str, list[int]]) -> tuple[list[int], list[str]]:
    """Ends and groups in their order from the clamp on."""
    for group, own in reached.items():
        if len(own) != 2:
            told = ", ".join(ends[k].what for k in own) or "none"
            raise InputError(
                f"group {group!r} has {len(own)} ends ({told}) instead of two. A piece reaches from the clamp, or a face that it shares "
                "with another piece, to the next face or to an interface point: name an interface point at a free end, cut the group "
                "where an interface point grips it between its ends, and leave branching bodies on one frame."
            )
    order, groups = [0], list[str]()
    while following := [group for group, own in reached.items() if order[-1] in own and group not in groups]:
        if len(following) > 1 or len(order) > len(reached):
            break
        first, second = reached[following[0]]
        groups.append(following[0])
        order.append(second if first == order[-1] else first)
    if len(groups) < len(reached) or len(set(order)) < len(order):
        lost = [group for group in reached if group not in groups] or groups
        raise InputError(
            f"the pieces are no chain from the clamp on: {', '.join(map(repr, lost))} cannot be put in a row. Clamp one end of the body "
            "alone, and cut it across."
        )
    return order, groups


ENDS = ("first", "second")
"""Names of the interface points at the ends of a piece, in the order of their coordinates."""


class PieceBodies(NamedTuple):
    """Uncut body, and the pieces in the order of the chain."""

    cut: CutMesh
    whole: DiscreteBody
    bodies: list[DiscreteBody]


def piece_bodies(named: NamedMesh) -> PieceBodies:
    """Uncut body and its pieces, cut from the mesh and assembled.

    Raises
    ------
    InputError
        Names the file, the key and what is wrong there.
    """
    with at_key(named.path, "pieces"):
        cut = cut_mesh(named)
    whole, bodies = discretised(named), []
    for piece in cut.pieces:
        with at_key(named.path, f"pieces, group {piece.group!r}"):
            bodies.append(discretised(_named(cut, piece)))
    return PieceBodies(cut, whole, bodies)


def _named(cut: CutMesh, piece: MeshPiece) -> NamedMesh:
    """Piece as a mesh of its own."""
    whole, ends = cut.named, dict(zip(ENDS, (cut.ends[k] for k in piece.ends), strict=True))
    blocks = {kind: np.searchsorted(piece.nodes, each) for kind, each in piece.blocks.items()}
    mesh = SolidMesh(whole.mesh.nodes[piece.nodes], blocks, masses=piece.masses)
    regions = {name: end.region for name, end in ends.items()}
    return replace(
        whole,
        file=whole.file.model_copy(update={"clamp": None, "interface_points": regions, "pieces": None}),
        mesh=mesh,
        boundary=faces_of(mesh.nodes, blocks),
        clamped=np.zeros(0, int),
        tied={name: np.searchsorted(piece.nodes, end.nodes) for name, end in ends.items()},
        surfaces={name: _on_piece(faces, piece, mesh) for name, faces in whole.surfaces.items()},
        motions={name: motion[piece.nodes] for name, motion in whole.motions.items()},
    )


def _on_piece(faces: BoundaryFaces, piece: MeshPiece, mesh: SolidMesh) -> BoundaryFaces:
    """Faces of a body's surface that belong to a piece, in the numbers of the piece's own mesh."""
    own = {kind: np.searchsorted(piece.nodes, each) for kind, each in faces.between(piece.nodes).faces.items()}
    return BoundaryFaces(mesh.nodes, own)
