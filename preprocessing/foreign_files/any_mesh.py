"""Meshes of all formats that have no reader of their own here, as meshio reads them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import meshio
import numpy as np
from meshio._mesh import topological_dimension

from preprocessing.foreign_files.contents import Elements, MeshContents
from preprocessing.foreign_files.element_kinds import KNOWN

LACKING = {"wedge15": 3, "pyramid13": 3, "hexahedron24": 3}
"""Dimension of the kinds that meshio 5.3.5 has no dimension of."""


def any_mesh(path: str, file_format: str | None = None) -> MeshContents:
    """All that is used of a mesh; of elements that never are, only the kind."""
    complete_kinds()
    raw = meshio.read(path, file_format=file_format)
    return MeshContents(
        points=np.asarray(raw.points, float),
        cells=[(block.type, _nodes(block.type, block.data)) for block in raw.cells],
        groups=[(_text(name), elements) for name, elements in _groups(raw)],
    )


def complete_kinds() -> None:
    """Tell meshio the dimension of kinds that its readers make, but its meshes refuse with a KeyError."""
    topological_dimension.update(LACKING)


def _nodes(kind: str, data: Any) -> np.ndarray:
    return np.asarray(data, np.int64) if kind in KNOWN else np.zeros((0, 0), np.int64)


def _text(name: Any) -> str:
    """A name that can be printed."""
    return str(name).encode("utf-8", "replace").decode()


def _groups(raw: Any) -> Iterator[tuple[str, Elements]]:
    """Names and elements of node sets, element sets and physical groups."""
    yield from ((name, [("vertex", np.asarray(members, np.int64)[:, None])]) for name, members in raw.point_sets.items())
    for name, sets in raw.cell_sets.items():
        if name not in raw.point_sets and not name.startswith("gmsh:"):
            of = zip(raw.cells, sets, strict=True)
            here = [(block, np.asarray(own, int)) for block, own in of if own is not None]
            yield name, [(block.type, _nodes(block.type, block.data)[own]) for block, own in here if block.type in KNOWN]
    for name, (tag, dimension) in raw.field_data.items():  # gmsh 2.2
        tags = raw.cell_data.get("gmsh:physical")
        if tags is not None and name not in raw.cell_sets:
            of = zip(raw.cells, tags, strict=True)
            here = [(block, np.asarray(own) == tag) for block, own in of if block.dim == dimension]
            yield name, [(block.type, _nodes(block.type, block.data)[own]) for block, own in here if block.type in KNOWN]
