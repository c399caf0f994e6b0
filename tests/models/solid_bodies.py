"""Bodies of solid elements for the tests: structured meshes of all kinds, and the files that preprocessing reads."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path

import meshio
import numpy as np

from preprocessing import build
from preprocessing.elements.solid_elements import CUBE, CUBE_MIDDLES
from preprocessing.foreign_files.mesh_reader import complete_kinds
from preprocessing.mesh.faces import TETRA_EDGES, WEDGE_EDGES
from preprocessing.mesh.solid_mesh import SolidMesh
from toolkit.reduced_model.model import InterfacePoint, ReducedModel

KINDS = ("triangle", "triangle6", "quad", "quad8", "quad9")
MODULUS, DENSITY, WIDTH = 210e9, 7800.0, 0.05


def rectangle(kind: str, cells: tuple[int, int], length: float, height: float, bent: float = 0.0) -> SolidMesh:
    """A rectangle from (0, -height / 2) to (length, height / 2); `bent` makes all its lines curved."""
    order = 1 if kind in ("triangle", "quad") else 2
    x, y = np.meshgrid(*(np.linspace(0, 1, order * n + 1) for n in cells), indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    corners = [number[order * i : order * i + order + 1, order * j : order * j + order + 1] for i, j in np.ndindex(*cells)]
    elements = np.array([members for square in corners for members in _cut(kind, square)])
    used, connectivity = np.unique(elements, return_inverse=True)
    nodes = np.column_stack([length * x.ravel(), height * (y.ravel() - 0.5)])[used]
    wave = np.column_stack([np.sin(5 * nodes[:, 1] / height), np.sin(4 * nodes[:, 0] / length)])
    groups = {"left": np.flatnonzero(nodes[:, 0] == 0), "right": np.flatnonzero(nodes[:, 0] == length)}
    return SolidMesh(nodes + bent * wave, {kind: connectivity.reshape(elements.shape)}, groups)


def _cut(kind: str, s: np.ndarray) -> list[list[int]]:
    """Elements of one cell, whose nodes are s[i, j]."""
    if kind == "triangle":
        return [[s[0, 0], s[1, 0], s[1, 1]], [s[0, 0], s[1, 1], s[0, 1]]]
    if kind == "triangle6":
        return [
            [s[0, 0], s[2, 0], s[2, 2], s[1, 0], s[2, 1], s[1, 1]],
            [s[0, 0], s[2, 2], s[0, 2], s[1, 1], s[1, 2], s[0, 1]],
        ]
    if kind == "quad":
        return [[s[0, 0], s[1, 0], s[1, 1], s[0, 1]]]
    around = [s[0, 0], s[2, 0], s[2, 2], s[0, 2], s[1, 0], s[2, 1], s[1, 2], s[0, 1]]
    return [around if kind == "quad8" else [*around, s[1, 1]]]


SPATIAL_KINDS = ("tetra", "tetra10", "hexahedron", "hexahedron20", "hexahedron27", "wedge", "wedge15")


def box(kind: str, cells: tuple[int, int, int], lengths: tuple[float, float, float], bent: float = 0.0) -> SolidMesh:
    """A box from (0, -b / 2, -c / 2) to (a, b / 2, c / 2); `bent` makes all its lines curved."""
    order = 1 if kind in ("tetra", "hexahedron", "wedge") else 2
    grid = np.meshgrid(*(np.linspace(0, 1, order * n + 1) for n in cells), indexing="ij")
    number = np.arange(grid[0].size).reshape(grid[0].shape)
    corners = [number[tuple(slice(order * i, order * i + order + 1) for i in cell)] for cell in np.ndindex(*cells)]
    elements = np.array([members for cube in corners for members in _cut_cube(kind, cube)])
    used, connectivity = np.unique(elements, return_inverse=True)
    unit = np.column_stack([axis.ravel() for axis in grid])[used]
    nodes = (unit - [0.0, 0.5, 0.5]) * lengths
    groups = {"left": np.flatnonzero(unit[:, 0] == 0), "right": np.flatnonzero(unit[:, 0] == 1)}
    groups["top"] = np.flatnonzero(unit[:, 2] == 1)
    wave = np.column_stack([np.sin(5 * unit[:, 1] + 2 * unit[:, 2]), np.sin(4 * unit[:, 0]), np.cos(3 * unit[:, 0] * unit[:, 1])])
    return SolidMesh(nodes + bent * wave, {kind: connectivity.reshape(elements.shape)}, groups, None, {}, len(nodes))


def _cut_cube(kind: str, s: np.ndarray) -> list[list[int]]:
    """Elements of one cell, whose nodes are s[i, j, k]."""
    n = len(s) - 1
    places = n * CUBE.astype(int)
    if kind.startswith("hexahedron"):
        every = np.vstack([places, (2 * CUBE_MIDDLES).astype(int)])[: int(kind.removeprefix("hexahedron") or 8)]
        return [[s[tuple(place)] for place in every]]
    if kind == "wedge":
        return [[s[tuple(place)] for place in half] for half in places[[(0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)]]]
    if kind == "wedge15":
        halves = places[[(0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)]]
        return [[s[tuple(place)] for place in [*half, *((half[a] + half[b]) // 2 for a, b in WEDGE_EDGES)]] for half in halves]
    found = []
    for axes in permutations(range(3)):  # Kuhn: from one corner to the opposite one along three edges
        path = np.cumsum([np.zeros(3, int), *(n * np.eye(3, dtype=int)[axis] for axis in axes)], axis=0)
        path = path if np.linalg.det(path[1:]) > 0 else path[[1, 0, 2, 3]]
        middles = [(path[a] + path[b]) // 2 for a, b in TETRA_EDGES] if kind == "tetra10" else []
        found.append([s[tuple(place)] for place in [*path, *middles]])
    return found


def write_mesh(mesh: SolidMesh, path: Path) -> None:
    """The mesh as a file of the format that the name's ending says."""
    points = np.column_stack([mesh.nodes, np.zeros((len(mesh.nodes), 3 - mesh.dimension))])
    complete_kinds()
    gmsh = {"file_format": "gmsh"} if path.suffix == ".msh" else {}  # not that of ANSYS Fluent
    meshio.write(path, meshio.Mesh(points, list(mesh.blocks.items())), **gmsh)


def write_body(
    folder: Path, mesh: SolidMesh, basis: str = 'kind = "full"', poisson_ratio: float = 0.3, tie: str = "averaged", more: str = ""
) -> Path:
    """body.toml of a rectangle or box clamped at its left end, with the interface points hub, on the clamp, and tip, at the right end."""
    left, right = (mesh.groups[name].tolist() for name in ("left", "right"))
    write_mesh(mesh, folder / "body.vtu")
    path = folder / "body.toml"
    path.write_text(
        f"""
units = "m-kg-s"
[mesh]
file = "body.vtu"
[material]
youngs_modulus = {MODULUS}
density = {DENSITY}
poisson_ratio = {poisson_ratio}
{f"[section]{chr(10)}width = {WIDTH}" if mesh.dimension == 2 else ""}
[damping]
stiffness = 1e-5
[clamp]
nodes = {left}
[interface_points.hub]
nodes = {left}
[interface_points.tip]
nodes = {right}
tie = "{tie}"
[basis]
{basis}
{more}"""
    )
    return path


def cantilever(folder: Path, mesh: SolidMesh, *args, **kwargs) -> ReducedModel:
    """The reduced model of `write_body`."""
    return build(write_body(folder, mesh, *args, **kwargs))


def moves(point: InterfacePoint) -> np.ndarray:
    """Displacements and rotations of an interface point per elastic coordinate, (3, n_f) or (6, n_f)."""
    return np.vstack([point.position[0][:, 1:], np.atleast_2d(point.rotation[0])[:, 1:]])


def compliance(model: ReducedModel, point: str = "tip") -> np.ndarray:
    """Displacements and rotations of a point per force and moment there, (3, 3) or (6, 6)."""
    rows = moves(model.interfaces[point])
    return rows @ np.linalg.solve(model.invariants.stiffness, rows.T)


def frequencies(model: ReducedModel) -> np.ndarray:
    """Frequencies in Hz of a body whose frame is fixed."""
    inv = model.invariants
    triangle = np.linalg.cholesky((inv.inertia if model.dimension == 2 else inv.second_moment[:3].sum(axis=0))[1:, 1:])
    half = np.linalg.solve(triangle, model.invariants.stiffness)
    return np.sqrt(np.linalg.eigvalsh(np.linalg.solve(triangle, half.T)).clip(0)) / (2 * np.pi)
