"""The finite-element mesh of the skin: stations on the curve go through gmsh and come back as plain arrays."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType

import numpy as np

from toolkit.foundation.errors import InputError


def load_gmsh() -> ModuleType:
    """Module gmsh, loaded when a mesh is wanted.

    Raises
    ------
    InputError
        It is not installed, or lacks a system library.
    """
    try:
        return import_module("gmsh")
    except (ImportError, OSError) as error:
        raise InputError(
            f"meshing needs gmsh, which cannot be loaded ({error}). Install it with: pip install "
            "'ffrf-toolkit[preprocessing]'; its system libraries on Debian: apt-get install libglu1-mesa libgl1 libxcursor1 libxft2 "
            "libxinerama1 libgomp1"
        ) from error


@contextmanager
def gmsh_model(name: str) -> Iterator[ModuleType]:
    """Context with a gmsh model of our own, which leaves a gmsh session of the caller as it was; gives the module."""
    gmsh = load_gmsh()
    if gmsh.isInitialized():
        current = gmsh.model.getCurrent()
        terminal = gmsh.option.getNumber("General.Terminal")
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add(name)
        try:
            yield gmsh
        finally:
            gmsh.model.remove()
            gmsh.option.setNumber("General.Terminal", terminal)
            if current:
                gmsh.model.setCurrent(current)
        return
    # gmsh's own signal handler would survive finalize and make Ctrl-C kill Python
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add(name)
        yield gmsh
    finally:
        gmsh.finalize()


_LINE, _POINT = 1, 15  # gmsh's numbers of the element types
_GMSH = threading.Lock()  # gmsh has one global state per process, shared between threads


@dataclass(frozen=True)
class CurveMesh:
    """Straight two-node elements along an open curve, nodes and elements numbered from its start F to its end G."""

    nodes: np.ndarray  # (n_nodes, 2)
    connectivity: np.ndarray  # (n_elements, 2)

    @property
    def ends(self) -> np.ndarray:
        """Positions of the two ends of every element, (n_elements, 2, 2)."""
        return self.nodes[self.connectivity]

    @property
    def dofs(self) -> np.ndarray:
        """Numbers of the nodal coordinates (x, y, rotation at both ends) of every element, (n_elements, 6)."""
        return (3 * self.connectivity[:, :, None] + np.arange(3)).reshape(-1, 6)


def mesh_curve(stations: np.ndarray) -> CurveMesh:
    """Mesh the curve through the stations, one element between neighbours.

    The stations enter gmsh as a discrete curve, which puts the nodes exactly where they are, with physical groups F, G and
    skin. gmsh numbers neither nodes nor elements along the curve, so both are renumbered by a walk from F.

    Parameters
    ----------
    stations : (n_nodes, 2)
        Positions in the order from F to G, at least two.

    Raises
    ------
    InputError
        Fewer than two stations, values that are not finite, or two neighbours at the same place.
    """
    stations = np.asarray(stations, dtype=float)
    _check(stations)
    with _GMSH, gmsh_model("skin") as gmsh:
        _enter(gmsh, stations)
        tags, positions = gmsh.model.mesh.getNodesForPhysicalGroup(1, _group(gmsh, 1, "skin"))
        start = int(gmsh.model.mesh.getNodesForPhysicalGroup(0, _group(gmsh, 0, "F"))[0][0])
        elements = gmsh.model.mesh.getElementsByType(_LINE)[1].reshape(-1, 2)
    order = walk(elements, start)
    rows = {int(tag): row for row, tag in enumerate(tags)}
    nodes = positions.reshape(-1, 3)[[rows[tag] for tag in order], :2]
    return CurveMesh(nodes, np.column_stack([np.arange(len(order) - 1), np.arange(1, len(order))]))


def walk(elements: np.ndarray, start: int) -> list[int]:
    """Node numbers of an open chain of two-node elements (n_elements, 2) in the order of a walk from `start`."""
    neighbours: dict[int, list[int]] = {}
    for one, other in elements.tolist():
        neighbours.setdefault(one, []).append(other)
        neighbours.setdefault(other, []).append(one)
    order = [start]
    while ahead := [node for node in neighbours[order[-1]] if node not in order[-2:]]:
        order.append(ahead[0])
    return order


def _check(stations: np.ndarray) -> None:
    if stations.ndim != 2 or stations.shape[1] != 2 or len(stations) < 2:
        raise InputError(f"a skin mesh needs at least two stations (x, y); got an array of shape {stations.shape}.")
    if not np.all(np.isfinite(stations)):
        raise InputError(f"station {np.argmin(np.isfinite(stations).all(axis=1))} of the skin is not finite; check the contour.")
    steps = np.linalg.norm(np.diff(stations, axis=0), axis=1)
    if steps.min() <= 1e-12 * steps.sum():
        raise InputError(f"stations {steps.argmin()} and {steps.argmin() + 1} of the skin coincide; use fewer elements.")


def _enter(gmsh: ModuleType, stations: np.ndarray) -> None:
    n = len(stations)
    spatial = np.column_stack([stations, np.zeros(n)])
    chain = np.column_stack([np.arange(1, n), np.arange(2, n + 1)])
    gmsh.model.addDiscreteEntity(0, 1)
    gmsh.model.addDiscreteEntity(0, 2)
    gmsh.model.addDiscreteEntity(1, 1, [1, 2])
    gmsh.model.mesh.addNodes(0, 1, [1], spatial[0])
    gmsh.model.mesh.addNodes(0, 2, [n], spatial[-1])
    gmsh.model.mesh.addNodes(1, 1, list(range(2, n)), spatial[1:-1].ravel())
    gmsh.model.mesh.addElementsByType(1, _POINT, [], [1])
    gmsh.model.mesh.addElementsByType(2, _POINT, [], [n])
    gmsh.model.mesh.addElementsByType(1, _LINE, [], chain.ravel())
    for dimension, tag, name in ((0, 1, "F"), (0, 2, "G"), (1, 1, "skin")):
        gmsh.model.addPhysicalGroup(dimension, [tag], name=name)


def _group(gmsh: ModuleType, dimension: int, name: str) -> int:
    groups = gmsh.model.getPhysicalGroups(dimension)
    return next(tag for _, tag in groups if gmsh.model.getPhysicalName(dimension, tag) == name)
