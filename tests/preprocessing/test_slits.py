"""Sides of elements that lie on one another without common nodes are told; neighbours that share theirs are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from preprocessing.builders.build_model import build
from preprocessing.mesh.overlaps import misfit_told, slit_told
from preprocessing.mesh.solid_mesh import SolidMesh
from tests.models.solid_bodies import KINDS, SPATIAL_KINDS, box, rectangle, write_body


def slit(mesh: SolidMesh) -> SolidMesh:
    """The mesh cut half-way through where x = 1/2: elements right of it have nodes of their own there."""
    x, y = mesh.nodes[:, :2].T
    twin = np.flatnonzero(np.isclose(x, 0.5) & (y < (y.min() + y.max()) / 2 - 1e-9))
    other = np.arange(len(mesh.nodes))
    other[twin] = len(mesh.nodes) + np.arange(len(twin))
    blocks = {kind: np.where(x[block].mean(axis=1)[:, None] > 0.5, other[block], block) for kind, block in mesh.blocks.items()}
    return replace(mesh, nodes=np.vstack([mesh.nodes, mesh.nodes[twin]]), blocks=blocks)


@pytest.mark.parametrize("kind", KINDS)
def test_a_slit_in_the_plane_is_told_with_its_sides(kind):
    mesh = rectangle(kind, (4, 4), 1.0, 0.4)
    assert slit_told(mesh) == ""
    assert "4 sides of elements lie on one another, but share no nodes" in slit_told(slit(mesh))


@pytest.mark.parametrize("kind", SPATIAL_KINDS)
def test_a_slit_in_space_is_told(kind):
    mesh = box(kind, (2, 4, 2), (1.0, 0.4, 0.2))
    assert slit_told(mesh) == ""
    assert "lie on one another, but share no nodes" in slit_told(slit(mesh))


def test_triangles_that_meet_quadrilaterals_are_told():
    """Cubes beside each other: of six tetrahedra and of one hexahedron, which share four nodes, against two of six tetrahedra each."""
    x, y, z = np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.0], [0.0, 1.0], indexing="ij")
    nodes, number = np.column_stack([x.ravel(), y.ravel(), z.ravel()]), np.arange(12).reshape(3, 2, 2)
    cubes = [number[k : k + 2] for k in (0, 1)]
    corner = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    steps = [
        (0, 1, 2),
        (0, 2, 1),
        (1, 0, 2),
        (1, 2, 0),
        (2, 0, 1),
        (2, 1, 0),
    ]  # along the axes, from the first corner to the last

    def tetrahedra(cube: np.ndarray) -> np.ndarray:
        ways = [np.cumsum([np.zeros(3, int), *np.eye(3, dtype=int)[list(step)]], axis=0) for step in steps]
        return np.array([[cube[tuple(place)] for place in way] for way in ways])

    hexahedron = np.array([[cubes[1][place] for place in corner]])
    mixed = SolidMesh(nodes, {"tetra": tetrahedra(cubes[0]), "hexahedron": hexahedron})
    assert misfit_told(mixed).startswith(
        "2 triangles of tetrahedra or wedges meet quadrilaterals of other elements, the first at (1, "
    )
    assert misfit_told(SolidMesh(nodes, {"tetra": np.concatenate([tetrahedra(cube) for cube in cubes])})) == ""
    wedges = box("wedge", (2, 1, 1), (1.0, 0.4, 0.2))
    assert misfit_told(wedges) == ""


def test_who_builds_a_body_with_a_slit_is_told(tmp_path):
    said: list[str] = []
    build(write_body(tmp_path, slit(rectangle("quad", (4, 4), 1.0, 0.4))), remark=said.append)
    assert len(said) == 1
    assert said[0].startswith("body.toml: the mesh has a slit: 4 sides")
