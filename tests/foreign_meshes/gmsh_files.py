"""Meshes that gmsh makes and writes in all of its formats, and what it says that they hold."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.builders.curve_mesh import gmsh_model

NAMES = {"left": "left 'é' side", "right": "right", "body": "body"}
SHAPES = ("triangle", "quad8", "tetra", "tetra10", "hexahedron", "wedge")
"""Kinds of elements of the meshes; the last two are one mesh's in the tests that count five."""
OPTIONS = {"Mesh.MshFileVersion": 4.1, "Mesh.Binary": 0, "Mesh.SaveAll": 0, "Mesh.SaveParametric": 0, "Mesh.BdfFieldFormat": 1}
"""Options of writing as they are at the beginning."""


@dataclass
class Truth:
    """What gmsh says of a mesh that it holds."""

    kind: str
    dimension: int
    elements: int  # of that kind
    nodes: int  # that they have
    groups: dict[str, np.ndarray] = field(default_factory=dict)  # name -> places of its nodes, sorted
    size: float = 2.0  # area or volume


@contextmanager
def meshed(kind: str, partitions: int = 0) -> Iterator[tuple[Any, Truth]]:
    """A plate or block of 2 by 1 (by 1) in gmsh, with groups of its ends and of all of it."""
    with gmsh_model(kind) as gmsh:
        gmsh.option.restoreDefaults()
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMin", 0.6)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.6)
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
        (plate if kind in ("triangle", "quad8") else block)(gmsh, kind)
        if kind in ("quad8", "tetra10"):
            gmsh.model.mesh.setOrder(2)
        if partitions:
            gmsh.model.mesh.partition(partitions)
        yield gmsh, truth(gmsh, kind)


def plate(gmsh: Any, kind: str) -> None:
    gmsh.model.occ.addRectangle(0, 0, 0, 2, 1)
    gmsh.model.occ.synchronize()
    if kind == "quad8":
        squares(gmsh)
    gmsh.model.addPhysicalGroup(2, [1], 1, NAMES["body"])
    gmsh.model.addPhysicalGroup(1, [-4], 2, NAMES["left"])  # against its direction
    gmsh.model.addPhysicalGroup(1, [2], 3, NAMES["right"])
    gmsh.model.mesh.generate(2)


def squares(gmsh: Any) -> None:
    for _, curve in gmsh.model.getEntities(1):
        gmsh.model.mesh.setTransfiniteCurve(curve, 3)
    gmsh.model.mesh.setTransfiniteSurface(1)
    gmsh.model.mesh.setRecombine(2, 1)


def block(gmsh: Any, kind: str) -> None:
    if kind.startswith("tetra"):
        gmsh.model.occ.addBox(0, 0, 0, 2, 1, 1)
    else:
        base = gmsh.model.occ.addRectangle(0, 0, 0, 2, 1)
        gmsh.model.occ.extrude([(2, base)], 0, 0, 1, [2], recombine=True)
    gmsh.model.occ.synchronize()
    if kind == "hexahedron":
        squares(gmsh)
    gmsh.model.addPhysicalGroup(3, [1], 1, NAMES["body"])
    for tag, name, x in ((2, "left", 0), (3, "right", 2)):
        ends = gmsh.model.getEntitiesInBoundingBox(x - 0.01, -1, -1, x + 0.01, 2, 2, 2)
        gmsh.model.addPhysicalGroup(2, [surface for _, surface in ends], tag, NAMES[name])
    gmsh.model.mesh.generate(3)


def truth(gmsh: Any, kind: str) -> Truth:
    dimension = gmsh.model.getDimension()
    _, tags, nodes = gmsh.model.mesh.getElements(dimension)
    found = Truth(kind, dimension, sum(map(len, tags)), len(np.unique(np.concatenate(nodes))))
    for each, tag in gmsh.model.getPhysicalGroups():
        _, places = gmsh.model.mesh.getNodesForPhysicalGroup(each, tag)
        found.groups[gmsh.model.getPhysicalName(each, tag)] = in_order(places.reshape(-1, 3)[:, :dimension])
    return found


def in_order(places: np.ndarray) -> np.ndarray:
    """Places sorted, to nine digits."""
    return np.unique(np.round(places, 9) + 0.0, axis=0)


def written(gmsh: Any, path: Path, **options: float) -> Path:
    """The mesh in a file, written with options whose points are underscores."""
    for name, value in {**OPTIONS, **{name.replace("_", "."): value for name, value in options.items()}}.items():
        gmsh.option.setNumber(name, value)
    gmsh.write(str(path))
    return path
