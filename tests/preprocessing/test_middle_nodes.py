"""Nodes between the corners of quadratic elements: other orders than the right one are refused, curved and thin elements are not."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import meshio
import numpy as np
import pytest

from preprocessing import build
from preprocessing.mesh.element_numbering import BETWEEN, refuse_exchanged, refuse_unlike
from preprocessing.mesh.mesh_file import read_mesh
from preprocessing.mesh.solid_mesh import SolidMesh
from tests.models.solid_bodies import box, rectangle, write_body, write_mesh
from toolkit.foundation.errors import InputError

pytestmark = pytest.mark.usefixtures("read_here")

FILE = Path("body.inp")
PLANE = ("triangle6", "quad8", "quad9")
OTHERS = {
    "gmsh": ("tetra10", [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]),
    "gmsh's": ("hexahedron20", [*range(8), 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14]),
    "gmsh's wedge": ("wedge15", [*range(6), 6, 8, 12, 7, 13, 14, 9, 11, 10]),
    "Nastran's": ("hexahedron20", [*range(12), *range(16, 20), *range(12, 16)]),
    "Nastran's wedge": ("wedge15", [*range(9), *range(12, 15), *range(9, 12)]),
    "one too far": ("hexahedron20", [*range(8), *range(9, 20), 8]),
    "from behind": ("quad8", [0, 1, 2, 3, 7, 6, 5, 4]),
    "gmsh's 27": ("hexahedron27", [*range(8), 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14, 24, 22, 20, 21, 23, 25, 26]),
}
"""Where the nodes of an element stand in other orders than that of mesh files here."""


def some(kind: str, bent: float = 0.02) -> SolidMesh:
    if kind in PLANE:
        return rectangle(kind, (2, 2), 1.0, 0.5, bent)
    return box(kind, (2, 1, 2), (1.0, 0.5, 0.3), bent)


def rolled(kind: str, thickness: float) -> SolidMesh:
    """A quarter of a tube of one layer, whose elements turn by 45 degrees each: their edges bend by more than they are thick."""
    mesh = box(kind, (2, 1, 1), (1.0, thickness, 1.0))
    angle, radius = mesh.nodes[:, 0] * np.pi / 2, 1 + mesh.nodes[:, 1]
    return SolidMesh(np.column_stack([radius * np.sin(angle), radius * np.cos(angle), mesh.nodes[:, 2]]), mesh.blocks)


@pytest.mark.parametrize("kind", BETWEEN)
@pytest.mark.parametrize("bent", [0.0, 0.01])
def test_any_two_exchanged_nodes_are_refused(kind, bent):
    mesh, corners = some(kind, bent), BETWEEN[kind][0]
    refuse_exchanged(FILE, mesh.nodes, mesh.blocks)
    for i, j in combinations(range(corners, mesh.blocks[kind].shape[1]), 2):
        block = mesh.blocks[kind].copy()
        block[1, [i, j]] = block[1, [j, i]]
        with pytest.raises(InputError, match=rf"^1 of the {len(block)} elements of kind {kind} .* middle of other edges"):
            refuse_exchanged(FILE, mesh.nodes, {kind: block})


@pytest.mark.parametrize("case", OTHERS)
def test_orders_of_other_programs_are_refused_for_every_element(case):
    kind, order = OTHERS[case]
    mesh = some(kind)
    block = mesh.blocks[kind][:, order]
    with pytest.raises(InputError, match=rf"^{len(block)} of the {len(block)} elements .* between the corners 1-2, 2-3,"):
        refuse_exchanged(FILE, mesh.nodes, {kind: block})


@pytest.mark.parametrize("kind", ["tetra10", "wedge15", "hexahedron20", "hexahedron27"])
@pytest.mark.parametrize("thickness", [0.3, 0.03, 0.003])
def test_thin_curved_elements_are_right(kind, thickness):
    mesh = rolled(kind, thickness)
    refuse_exchanged(FILE, mesh.nodes, mesh.blocks)


def test_nodes_in_the_quarters_of_their_edges_are_right():
    """As round the tip of a crack: those of edges that end there are twice as near to it."""
    mesh = rectangle("quad8", (1, 1), 1.0, 1.0)
    nodes = mesh.nodes.copy()
    nodes[(nodes[:, 0] == 0.5) & (nodes[:, 1] == -0.5), 0] = 0.25
    nodes[(nodes[:, 0] == 0) & (nodes[:, 1] == 0), 1] = -0.25
    assert np.count_nonzero((nodes != mesh.nodes).any(axis=1)) == 2
    refuse_exchanged(FILE, nodes, mesh.blocks)


def test_exchanged_nodes_are_refused_by_file_and_place(tmp_path):
    """Elements with their last two nodes exchanged, as gmsh lists them: some of them are not even folded over."""
    mesh = box("tetra10", (2, 1, 1), (1.0, 0.5, 0.3))
    path = write_body(tmp_path, mesh)
    write_mesh(SolidMesh(mesh.nodes, {"tetra10": mesh.blocks["tetra10"][:, OTHERS["gmsh"][1]]}), tmp_path / "body.vtu")
    with pytest.raises(InputError, match=r"mesh.file: 12 of the 12 elements of kind tetra10 .* round \(.*Export the mesh"):
        build(path)


def beside(first: str, second: str) -> SolidMesh:
    """Two blocks of one kind each, with the corners between them in common, and nodes in the middle of edges if both have them."""
    plane = first in (*PLANE, "triangle", "quad")
    one, other = (rectangle(k, (1, 1), 1.0, 1.0) if plane else box(k, (1, 1, 1), (1.0, 1.0, 1.0)) for k in (first, second))
    every = np.vstack([one.nodes, other.nodes + np.eye(one.dimension)[0]])
    nodes, number = np.unique(every.round(12), axis=0, return_inverse=True)
    number = number.ravel()
    return SolidMesh(nodes, {first: number[one.blocks[first]], second: number[other.blocks[second] + len(one.nodes)]})


@pytest.mark.parametrize(
    "kinds",
    [("triangle", "triangle6"), ("quad8", "quad"), ("triangle", "quad8"), ("hexahedron", "hexahedron20"), ("wedge15", "wedge")],
)
def test_elements_of_two_orders_that_meet_are_refused_by_the_ends_of_an_edge(kinds, tmp_path):
    mesh = beside(*kinds)
    write_mesh(mesh, tmp_path / "body.vtu")
    with pytest.raises(
        InputError, match=r"^\d edges of elements .* one is between \(1, .*\) and \(1, .*\)\. Mesh the whole body"
    ):
        read_mesh(tmp_path / "body.vtu")


@pytest.mark.parametrize(
    "kinds",
    [("triangle6", "quad8"), ("quad9", "triangle6"), ("hexahedron20", "wedge15"), ("triangle", "quad"), ("hexahedron", "wedge")],
)
def test_kinds_of_one_order_may_meet(kinds):
    mesh = beside(*kinds)
    refuse_unlike(FILE, mesh.nodes, mesh.blocks)


def test_two_nodes_in_the_middle_of_one_edge_and_one_node_in_two_are_refused(tmp_path):
    """A slit that only middle nodes have: the corners are merged, and these are not."""
    mesh = rectangle("quad8", (2, 1), 1.0, 1.0)
    block = mesh.blocks["quad8"].copy()
    (shared,) = set(block[0, 4:]) & set(block[1, 4:])
    block[1, 4:][block[1, 4:] == shared] = len(mesh.nodes)
    nodes = np.vstack([mesh.nodes, mesh.nodes[shared]])
    with pytest.raises(InputError, match=r"^1 edges of elements .* between \(0.5, -0.5\) and \(0.5, 0.5\)"):
        refuse_unlike(FILE, nodes, {"quad8": block})
    block = mesh.blocks["quad8"].copy()
    block[1, 4] = block[0, 4]
    with pytest.raises(InputError, match="edges of elements"):
        refuse_unlike(FILE, mesh.nodes, {"quad8": block})
    meshio.write(tmp_path / "body.vtu", meshio.Mesh(np.column_stack([nodes, 0 * nodes[:, 0]]), [("quad8", block)]))
    with pytest.raises(InputError):
        read_mesh(tmp_path / "body.vtu")
