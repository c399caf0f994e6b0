"""Nodes and elements of a .msh file of gmsh, as its sections give them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.contents import Elements, MeshContents
from preprocessing.foreign_files.gmsh.groups import Group, named_groups
from preprocessing.foreign_files.gmsh.kinds import KINDS, GmshKind, reordered
from preprocessing.foreign_files.gmsh.sections import REMEDY
from preprocessing.foreign_files.meshes.wrong_file import Labels, wrong_file


class Nodes(NamedTuple):
    """Tags and places of all nodes."""

    tags: np.ndarray  # (n,)
    points: np.ndarray  # (n, 3)


class Block(NamedTuple):
    """Elements of one kind."""

    kind: GmshKind
    nodes: np.ndarray  # (n_e, n_local), tags in the order of gmsh
    groups: Sequence[tuple[int, np.ndarray | slice]]  # tag of a physical group, and which of the elements are in it


def known_kind(path: Path, number: int) -> GmshKind:
    """The kind of element with a number in gmsh.

    Raises
    ------
    InputError
        It is none of those that are known here.
    """
    if number not in KINDS:
        raise wrong_file(
            path,
            "it holds elements besides points, lines, triangles, quadrilaterals, tetrahedra, hexahedra, prisms and pyramids",
            "Mesh the body with these.",
        )
    return KINDS[number]


def contents(path: Path, nodes: Nodes, blocks: Sequence[Block], names: dict[Group, str], remarks: Sequence[str]) -> MeshContents:
    """The record of a mesh: nodes counted from 0, and groups by their names."""
    labels = Labels(path, nodes.tags, "node", REMEDY)
    cells: Elements = []
    members: dict[Group, Elements] = {}
    for block in blocks:
        cells.append((block.kind.kind, reordered(block.kind.kind, labels.places(block.nodes))))
        for tag, own in block.groups:
            members.setdefault((block.kind.dimension, tag), []).append((block.kind.kind, cells[-1][1][own]))
    groups, told = named_groups(members, names)
    return MeshContents(nodes.points, cells, groups, nodes.tags, remarks=[*remarks, *told])
