"""Bodies of solid elements for the tests: structured meshes of all kinds, and the files that preprocessing reads."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np

from preprocessing.solids.build_body import build_body
from preprocessing.solids.solid_mesh import SolidMesh
from toolkit.reduced_model import ReducedModel

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


def write_mesh(mesh: SolidMesh, path: Path) -> None:
    """The mesh as a file of the format that the name's ending says."""
    points = np.column_stack([mesh.nodes, np.zeros(len(mesh.nodes))])
    gmsh = {"file_format": "gmsh"} if path.suffix == ".msh" else {}  # not that of ANSYS Fluent
    meshio.write(path, meshio.Mesh(points, list(mesh.blocks.items())), **gmsh)


def write_body(
    folder: Path, mesh: SolidMesh, basis: str = 'kind = "full"', poisson_ratio: float = 0.3, tie: str = "averaged", more: str = ""
) -> Path:
    """body.toml of a rectangle clamped at its left edge, with the interface points hub, on the clamp, and tip, at the right edge."""
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
[section]
width = {WIDTH}
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
    return build_body(write_body(folder, mesh, *args, **kwargs))


def compliance(model: ReducedModel, point: str = "tip") -> np.ndarray:
    """Displacement x, y and rotation of a point per force and moment there, (3, 3)."""
    position, rotation = model.interfaces[point].here
    rows = np.vstack([position[:, 1:], rotation[1:]])
    return rows @ np.linalg.solve(model.invariants.stiffness, rows.T)


def frequencies(model: ReducedModel) -> np.ndarray:
    """Frequencies in Hz of a body whose frame is fixed."""
    triangle = np.linalg.cholesky(model.invariants.inertia[1:, 1:])
    half = np.linalg.solve(triangle, model.invariants.stiffness)
    return np.sqrt(np.linalg.eigvalsh(np.linalg.solve(triangle, half.T)).clip(0)) / (2 * np.pi)
