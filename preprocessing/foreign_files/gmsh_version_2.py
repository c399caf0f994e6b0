"""Files of gmsh's formats MSH 1 and 2, as text and, since 2, binary: every element has its physical group."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.contents import alike_rows, wrong_file
from preprocessing.foreign_files.gmsh_sections import REMEDY, BinaryNumbers, GmshBlock, GmshKind, Nodes, TextNumbers, known_kind

SPREAD = 0x9E3779B97F4A7C15
"""Odd number of 64 bits whose powers make one number of the nodes of an element."""


class ElementRows(NamedTuple):
    """Elements of one kind as they stand in the file; one that is in several groups stands there several times."""

    kind: GmshKind
    groups: np.ndarray  # (n_e,) tags of physical groups; 0 where an element is in none
    entities: np.ndarray  # (n_e,) tags of the curves, surfaces, ... that they are parts of
    nodes: np.ndarray  # (n_e, n_local), tags


def text_nodes(numbers: TextNumbers) -> Nodes:
    """Nodes of $Nodes, or $NOD in the first version: rows of tag, x, y, z."""
    rows = numbers.table(int(numbers.whole(1)[0]), 4)
    return Nodes(numbers.as_whole(rows[:, 0]), rows[:, 1:])


def parametric_nodes(path: Path, numbers: TextNumbers) -> Nodes:
    """Nodes of $ParametricNodes: rows of tag, x, y, z, dimension and tag of the entity, and parameters on a curve or surface."""
    n = int(numbers.whole(1)[0])
    found = list(_runs(path, numbers, (4,), lambda head: 6 + {1.0: 1, 2.0: 2}.get(head[4], 0)))
    rows = np.concatenate([np.zeros((0, 4)), *(block[:, :4] for block in found)])
    if len(rows) != n:
        raise wrong_file(path, "$ParametricNodes has not as many nodes as it says", REMEDY)
    return Nodes(numbers.as_whole(rows[:, 0]), rows[:, 1:])


def binary_nodes(numbers: BinaryNumbers, n: int) -> Nodes:
    """Nodes of a binary $Nodes: records of tag, x, y, z."""
    rows = numbers.rows(n, [("tag", "int", ()), ("place", "real", (3,))])
    return Nodes(rows["tag"].astype(np.int64), rows["place"].astype(float))


def text_elements(path: Path, numbers: TextNumbers, first_version: bool) -> list[GmshBlock]:
    """Elements of $Elements, or $ELM in the first version, by kind.

    Rows of number, type, number of tags, tags (group, entity, partitions), nodes.
    """
    n = int(numbers.whole(1)[0])
    read = _first_rows if first_version else _rows
    return _blocks(path, n, read(path, numbers))


def _rows(path: Path, numbers: TextNumbers) -> Iterator[ElementRows]:
    def width(head: np.ndarray) -> int:
        return 3 + int(head[2]) + known_kind(path, head[1]).nodes if 0 <= head[2] < len(numbers.values) else 0

    for block in _runs(path, numbers, (1, 2), width):
        whole = numbers.as_whole(block)
        yield _split(known_kind(path, int(whole[0, 1])), whole[:, 3:], int(whole[0, 2]))


def _first_rows(path: Path, numbers: TextNumbers) -> Iterator[ElementRows]:
    """Rows of number, type, group, entity, number of nodes, nodes."""
    for block in _runs(path, numbers, (1, 4), lambda head: 5 + known_kind(path, head[1]).nodes):
        kind = known_kind(path, int(block[0, 1]))
        if block[0, 4] != kind.nodes:
            raise wrong_file(path, f"$ELM has a {kind.kind} without its {kind.nodes} nodes", REMEDY)
        whole = numbers.as_whole(block)
        yield ElementRows(kind, np.abs(whole[:, 2]), whole[:, 3], whole[:, 5:])


def _runs(
    path: Path, numbers: TextNumbers, columns: tuple[int, ...], width_of: Callable[[np.ndarray], int]
) -> Iterator[np.ndarray]:
    """Rows of one width, as long as the given columns stay the same."""
    for block in alike_rows(numbers.values, numbers.at, columns, width_of):
        if block is None:
            raise wrong_file(path, f"a row of ${numbers.section.name} has not as many numbers as it should", REMEDY)
        yield block
    numbers.at = len(numbers.values)


def binary_elements(path: Path, numbers: BinaryNumbers, n: int) -> list[GmshBlock]:
    """Elements of a binary $Elements, by kind.

    Blocks behind type, number of elements and of tags, with records of number, tags, nodes.
    """

    def rows() -> Iterator[ElementRows]:
        read = 0
        while read < n:
            number, n_here, n_tags = numbers.whole(3).tolist()
            kind = known_kind(path, number)
            if n_here < 1 or n_tags < 0:
                raise wrong_file(path, "a block of $Elements has no elements", REMEDY)
            flat = numbers.whole(n_here * (1 + n_tags + kind.nodes)).reshape(n_here, -1)
            yield _split(kind, flat[:, 1:], n_tags)
            read += n_here

    return _blocks(path, n, rows())


def _split(kind: GmshKind, whole: np.ndarray, n_tags: int) -> ElementRows:
    """Rows of tags and nodes; the first tag is the group, with the sign of a direction, and the second the entity."""
    none = np.zeros(len(whole), np.int64)
    tags = [whole[:, k] if k < n_tags else none for k in range(2)]
    return ElementRows(kind, np.abs(tags[0]), tags[1], whole[:, n_tags:])


def _blocks(path: Path, n: int, rows: Iterable[ElementRows]) -> list[GmshBlock]:
    """Elements by kind, those of several groups once."""
    found: dict[GmshKind, list[ElementRows]] = {}
    for each in rows:
        found.setdefault(each.kind, []).append(each)
    if sum(len(each.groups) for of in found.values() for each in of) != n:
        raise wrong_file(path, "$Elements has not as many elements as it says", REMEDY)
    return [
        _block(kind, *(np.concatenate(parts) for parts in zip(*(each[1:] for each in of), strict=True)))
        for kind, of in found.items()
    ]


def _block(kind: GmshKind, groups: np.ndarray, entities: np.ndarray, nodes: np.ndarray) -> GmshBlock:
    """The elements of one kind, and which of them are in which group."""
    same = _same(groups, entities, nodes)
    kept = np.flatnonzero(same == np.arange(len(same)))
    place = np.searchsorted(kept, same)
    order = np.argsort(groups, kind="stable")
    tags, starts = np.unique(groups[order], return_index=True)
    members = [(int(tag), np.unique(place[own])) for tag, own in zip(tags, np.split(order, starts[1:]), strict=True) if tag]
    return GmshBlock(kind, nodes[kept], members)


def _same(groups: np.ndarray, entities: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Number of the first row of the same element for each row; gmsh writes an element once for each of its groups.

    Rows are of the same element if they have its nodes, in any order as a group may be against its direction, are of one entity and of
    different groups. Elements that are there twice otherwise remain.
    """
    same = np.arange(len(nodes))
    rows = _repeated(nodes)
    if not len(rows):
        return same
    _, first, of = np.unique(
        np.column_stack([np.sort(nodes[rows], axis=1), entities[rows]]), axis=0, return_index=True, return_inverse=True
    )
    of = of.ravel()
    order = np.lexsort((groups[rows], of))
    again = np.append(False, (np.diff(of[order]) == 0) & (np.diff(groups[rows][order]) == 0))
    twice = np.bincount(of[order], again | (groups[rows][order] == 0)) > 0
    same[rows] = np.where(twice[of], rows, rows[first][of])
    return same


def _repeated(nodes: np.ndarray) -> np.ndarray:
    """Rows of which another one has, in all likelihood, the same nodes in some order."""
    key = np.sort(nodes, axis=1).astype(np.uint64) @ np.cumprod(np.full(nodes.shape[1], SPREAD, np.uint64))
    order = np.argsort(key, kind="stable")
    alike = key[order][1:] == key[order][:-1]
    return np.sort(order[np.append(alike, False) | np.append(False, alike)])
