"""Elements that lie in one another are refused, because their mass would count twice; neighbours of every shape are not."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

from preprocessing import build
from preprocessing.mesh.mesh_file import read_mesh
from preprocessing.mesh.overlaps import refuse_overlaps
from preprocessing.mesh.solid_mesh import SolidMesh
from tests.models.solid_bodies import KINDS, SPATIAL_KINDS, box, rectangle, write_body
from toolkit.foundation.errors import InputError

pytestmark = pytest.mark.usefixtures("read_here")

MODELS = Path(__file__).parents[2] / "models"
TWICE = "lie in one another, so that their mass would count twice"


def joined(*meshes: SolidMesh) -> SolidMesh:
    """One mesh of all elements; nodes at one place become one."""
    nodes, blocks, first = [], {}, 0
    for mesh in meshes:
        nodes.append(mesh.nodes)
        for kind, block in mesh.blocks.items():
            blocks.setdefault(kind, []).append(block + first)
        first += len(mesh.nodes)
    _, kept, number = np.unique(np.round(np.vstack(nodes), 9), axis=0, return_index=True, return_inverse=True)
    return SolidMesh(np.vstack(nodes)[kept], {kind: number.ravel()[np.concatenate(each)] for kind, each in blocks.items()})


def moved(mesh: SolidMesh, *by: float) -> SolidMesh:
    return SolidMesh(mesh.nodes + np.array(by), mesh.blocks)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("height", "bent"), [(0.2, 0.0), (0.2, 0.03), (0.01, 0.02)])
def test_plane_elements_beside_each_other_are_none(kind, height, bent):
    """Also curved ones whose neighbours lie in the hollow of their sides, and mirrored ones."""
    mesh = rectangle(kind, (8, 3), 1.0, height, bent)
    refuse_overlaps(mesh)
    refuse_overlaps(SolidMesh(mesh.nodes * [1, -1], mesh.blocks))


@pytest.mark.parametrize("kind", SPATIAL_KINDS)
@pytest.mark.parametrize(("height", "bent"), [(0.2, 0.0), (0.2, 0.02), (0.02, 0.02)])
def test_spatial_elements_beside_each_other_are_none(kind, height, bent):
    mesh = box(kind, (4, 2, 2), (1.0, height, 0.2), bent)
    refuse_overlaps(mesh)
    refuse_overlaps(SolidMesh(mesh.nodes * [1, 1, -1], mesh.blocks))


@pytest.mark.parametrize("name", ["bracket", "spatial_bracket"])
def test_meshes_of_gmsh_have_none(name):
    refuse_overlaps(read_mesh(MODELS / name / "bracket.msh"))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("other", KINDS)
def test_two_plane_meshes_of_one_region_are_refused(kind, other):
    """With the same corners and with others; a quarter of the one in the middle of the other."""
    one = rectangle(kind, (12, 4), 1.0, 0.2)
    for second in (
        rectangle(other, (12, 4), 1.0, 0.2),
        rectangle(other, (7, 3), 1.0, 0.2),
        moved(rectangle(other, (3, 2), 0.25, 0.1), 0.25, 0),
    ):
        if kind != other or len(second.nodes) != len(one.nodes):  # elements that are the same are none of two
            with pytest.raises(InputError, match=TWICE):
                refuse_overlaps(joined(one, second))


@pytest.mark.parametrize("kind", SPATIAL_KINDS)
def test_two_spatial_meshes_of_one_region_are_refused(kind):
    one = box(kind, (6, 3, 3), (1.0, 0.2, 0.2))
    for second in (box(kind, (5, 2, 2), (1.0, 0.2, 0.2)), box("hexahedron", (3, 2, 2), (0.5, 0.1, 0.1))):
        with pytest.raises(InputError, match=TWICE):
            refuse_overlaps(joined(one, second))


def test_the_message_counts_and_names_the_places():
    mesh = joined(rectangle("quad", (4, 1), 1.0, 0.25), moved(rectangle("quad", (1, 1), 0.5, 0.25), 0.5, 0.0))
    expected = (
        r"3 of the 5 elements of the mesh .*the quad round \(0.625, 0\) and the quad round \(0.75, 0\) are the first\. Delete one"
    )
    with pytest.raises(InputError, match=expected):
        refuse_overlaps(mesh)


@pytest.mark.parametrize("offset", [0.5, 0.1])
def test_parts_that_touch_or_only_just_enter_one_another_are_none(offset):
    """Two squares with nodes of their own, joined by a third one; at 0.5 they touch, at 0.4 they share a fifth of an element."""
    part = rectangle("quad", (4, 4), 1.0, 1.0)
    beside = moved(rectangle("quad", (5, 5), 1.0, 1.0), 1.0 - 0.01 * (offset < 0.5), 0.0)
    refuse_overlaps(joined(part, beside))
    with pytest.raises(InputError, match=TWICE):
        refuse_overlaps(joined(part, moved(beside, -0.2, 0.0)))


def test_the_mass_of_overlapping_meshes_never_becomes_a_model(tmp_path):
    mesh = joined(rectangle("quad", (6, 2), 1.0, 0.2), rectangle("quad", (3, 1), 1.0, 0.2))
    left, right = (np.flatnonzero(mesh.nodes[:, 0] == x) for x in (0.0, 1.0))
    path = write_body(tmp_path, SolidMesh(mesh.nodes, mesh.blocks, {"left": left, "right": right}), 'kind = "static"')
    with pytest.raises(InputError, match=f"body.toml', mesh.file: .*15 of the 15 elements of the mesh {TWICE}"):
        build(path)


@pytest.mark.parametrize("name", ["mesh.inp", "mesh.vtu"])
def test_elements_that_a_file_holds_twice_are_refused(name, tmp_path):
    mesh = rectangle("quad", (4, 1), 1.0, 0.25)
    points = np.column_stack([mesh.nodes, 0 * mesh.nodes[:, 0]])
    elements = np.vstack([mesh.blocks["quad"], mesh.blocks["quad"][1:3, [1, 2, 3, 0]]])
    meshio.write(tmp_path / name, meshio.Mesh(points, [("quad", elements)]))
    with pytest.raises(InputError, match=r"holds 2 elements twice, the first round \(0.375, 0, 0\), .* Delete the copies"):
        read_mesh(tmp_path / name)
