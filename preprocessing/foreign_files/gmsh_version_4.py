"""Files of gmsh's format MSH 4.1, as text and binary."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from preprocessing.foreign_files.contents import wrong_file
from preprocessing.foreign_files.gmsh_sections import REMEDY, GmshBlock, Nodes, SectionNumbers, known_kind

Entity = tuple[int, int]
"""Dimension and tag of a point, curve, surface or volume."""


def entities(numbers: SectionNumbers) -> dict[Entity, tuple[int, ...]]:
    """Tags of the physical groups of every entity, from $Entities."""
    counts = numbers.whole(4, "size")
    return {entity: tags for dimension in range(4) for entity, tags in _of_one_dimension(numbers, dimension, counts, False)}


def partitioned_entities(numbers: SectionNumbers) -> dict[Entity, tuple[int, ...]]:
    """Tags of the physical groups of every piece into which a partition cuts an entity, from $PartitionedEntities."""
    numbers.whole(1, "size")  # partitions
    for _ in range(int(numbers.whole(1, "size")[0])):  # entities of ghosts, which hold no elements of their own
        numbers.whole(2)
    counts = numbers.whole(4, "size")
    return {entity: tags for dimension in range(4) for entity, tags in _of_one_dimension(numbers, dimension, counts, True)}


def _of_one_dimension(
    numbers: SectionNumbers, dimension: int, counts: np.ndarray, partitioned: bool
) -> list[tuple[Entity, tuple[int, ...]]]:
    found = []
    for _ in range(int(counts[dimension])):
        tag = int(numbers.whole(1)[0])
        if partitioned:
            numbers.whole(2)  # the entity that was cut
            _list(numbers)  # partitions
        numbers.real(6 if dimension else 3)  # the box around it, or the place of a point
        found.append(((dimension, tag), _list(numbers)))
        if dimension:
            _list(numbers)  # its boundary
    return found


def _list(numbers: SectionNumbers) -> tuple[int, ...]:
    """A list of tags behind its length; the sign of a tag is a direction."""
    return tuple(map(abs, numbers.whole(int(numbers.whole(1, "size")[0])).tolist()))


def nodes(path: Path, numbers: SectionNumbers) -> Nodes:
    """Nodes of $Nodes, in blocks of one entity each."""
    n_blocks, n_nodes = numbers.whole(4, "size")[:2].tolist()
    tags, points = [np.zeros(0, np.int64)], [np.zeros((0, 3))]
    for _ in range(n_blocks):
        dimension, _tag, parametric = numbers.whole(3).tolist()
        n = int(numbers.whole(1, "size")[0])
        tags.append(numbers.whole(n, "size"))
        width = 3 + (dimension if parametric else 0)
        if not 3 <= width <= 6:
            raise wrong_file(path, "$Nodes has an entity of a dimension besides 0 to 3", REMEDY)
        points.append(numbers.real(n * width).reshape(-1, width)[:, :3])
    found = Nodes(np.concatenate(tags), np.concatenate(points))
    if len(found.tags) != n_nodes:
        raise wrong_file(path, "$Nodes has not as many nodes as it says", REMEDY)
    return found


def elements(path: Path, numbers: SectionNumbers, groups: Mapping[Entity, tuple[int, ...]]) -> list[GmshBlock]:
    """Elements of $Elements, in blocks of one entity and one kind each."""
    n_blocks, n_elements = numbers.whole(4, "size")[:2].tolist()
    found = []
    for _ in range(n_blocks):
        dimension, tag, number = numbers.whole(3).tolist()
        kind = known_kind(path, number)
        if kind.dimension != dimension:
            raise wrong_file(path, "$Elements has elements on an entity of another dimension", REMEDY)
        n = int(numbers.whole(1, "size")[0])
        rows = numbers.whole(n * (1 + kind.nodes), "size").reshape(-1, 1 + kind.nodes)
        of = [(group, slice(None)) for group in dict.fromkeys(groups.get((dimension, tag), ()))]
        found.append(GmshBlock(kind, rows[:, 1:], of))
    if sum(len(block.nodes) for block in found) != n_elements:
        raise wrong_file(path, "$Elements has not as many elements as it says", REMEDY)
    return found
