"""Hexahedra, wedges and quadrilaterals with repeated nodes are the wedges, tetrahedra and triangles that they look like."""

from __future__ import annotations

from itertools import permutations, product
from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.spatial import ConvexHull

from preprocessing import build
from preprocessing.builders.body_recipe import BodyRecipe
from preprocessing.builders.discrete_body import discrete_body
from preprocessing.elements import solid_elements
from preprocessing.elements.elasticity import solid_matrices
from preprocessing.elements.solid_elements import CUBE, element_blocks
from preprocessing.foreign_files.contents import MeshContents
from preprocessing.mesh.element_numbering import FORMS, uncollapsed
from preprocessing.mesh.mesh_file import read_mesh
from preprocessing.mesh.solid_mesh import SolidMesh
from tests.models.solid_bodies import box, rectangle, write_body
from tests.preprocessing.test_solid_inputs import same
from toolkit.foundation.errors import InputError

pytestmark = pytest.mark.usefixtures("read_here")

SHEARED = np.array([[1.3, 0.2, -0.1], [0.3, 0.9, 0.2], [-0.2, 0.1, 1.1]])
HEXAHEDRA = {
    "face to an edge": ([0, 1, 2, 2, 4, 5, 6, 6], "wedge"),
    "and the upper face to a point": ([0, 1, 2, 2, 4, 4, 4, 4], "tetra"),
    "and two edges along": ([0, 1, 2, 2, 0, 1, 6, 6], "tetra"),
    "two opposite faces across one another": ([0, 0, 2, 2, 4, 5, 5, 4], "tetra"),
}
"""Where the nodes of collapsed hexahedra stand first, and what they are."""
WEDGES = {
    "upper face to a point": ([0, 1, 2, 3, 3, 3], "tetra"),
    "two edges along": ([0, 1, 2, 0, 1, 5], "tetra"),
}
PLACES = {"hexahedron": CUBE, "wedge": CUBE[[0, 1, 2, 4, 5, 6]], "quad": CUBE[:4]}


def turned(kind: str) -> list[list[int]]:
    """All ways to number the corners of a reference element anew so that the edges stay, also as a mirror image."""
    edges, n = {frozenset(edge) for edge in FORMS[kind].edges}, len(PLACES[kind])
    if kind == "hexahedron":
        every = [CUBE[:, axes] for axes in map(list, permutations(range(3)))]
        every = [np.where(flip, 1 - place, place) for place in every for flip in product((False, True), repeat=3)]
        return [[int(np.flatnonzero((corner == CUBE).all(axis=1))[0]) for corner in place] for place in every]
    return [list(p) for p in permutations(range(n)) if {frozenset(p[k] for k in edge) for edge in edges} == edges]


def with_middles(kind: str, corners: list[int], points: list[np.ndarray]) -> list[int]:
    """The nodes of a quadratic element with these corners; new ones are added to the points."""
    new: dict[frozenset[int], int] = {}
    for edge in FORMS[kind].edges:
        ends = frozenset(corners[k] for k in edge)
        if ends not in new:
            new[ends] = len(points) if len(ends) == 2 else min(ends)
            if len(ends) == 2:
                points.append(np.mean([points[k] for k in ends], axis=0))
    return [*corners, *(new[frozenset(corners[k] for k in edge)] for edge in FORMS[kind].edges)]


def contents(cells: list, points: np.ndarray, groups: list | None = None) -> MeshContents:
    return MeshContents(points, [(kind, np.array(rows)) for kind, rows in cells], groups or [])


def volumes(found: MeshContents) -> np.ndarray:
    """Of all elements."""
    blocks = element_blocks(SolidMesh(found.points, dict(found.cells)))
    return np.concatenate([block.functions().dx.sum(axis=1) for block in blocks])


@pytest.mark.parametrize("quadratic", [False, True])
@pytest.mark.parametrize(("kind", "case"), [*(("hexahedron", each) for each in HEXAHEDRA), *(("wedge", each) for each in WEDGES)])
def test_elements_collapsed_in_all_orientations_keep_their_volume(kind, case, quadratic):
    """Against the volume of the hull of their corners; in each of the 48 or 12 ways to number them, mirror images among these."""
    pattern, expected = {"hexahedron": HEXAHEDRA, "wedge": WEDGES}[kind][case]
    points, rows = [*(PLACES[kind] @ SHEARED)], []
    used = sorted(set(pattern))
    volume = ConvexHull(np.array(points)[used]).volume
    for order in turned(kind):
        corners = [pattern[k] for k in order]
        rows.append(with_middles(kind, corners, points) if quadratic else corners)
    name = {"hexahedron": "hexahedron20", "wedge": "wedge15"}[kind] if quadratic else kind
    found = uncollapsed(Path("body.vtu"), contents([(name, rows)], np.array(points)))
    ((made, elements_found),) = found.cells
    assert made == {"wedge": "wedge15", "tetra": "tetra10"}.get(expected) if quadratic else made == expected
    assert len(rows) == {"hexahedron": 48, "wedge": 12}[kind]
    np.testing.assert_allclose(volumes(found), np.full(len(rows), volume), rtol=1e-12)  # round-off
    np.testing.assert_array_equal(np.unique(elements_found[:, : len(used)]), used)


def collapsed_box(kind: str, cells: tuple[int, int, int], seed: int) -> tuple[SolidMesh, np.ndarray]:
    """A box of wedges, and its elements as collapsed hexahedra that are numbered in random orientations."""
    mesh, rng = box(kind, cells, (2.0, 0.5, 0.4), bent=0.02), np.random.default_rng(seed)
    places = [0, 1, 2, 2, 3, 4, 5, 5]
    if kind == "wedge15":
        places += [6, 7, 2, 8, 9, 10, 5, 11, 12, 13, 14, 14]  # middles of the hexahedron's edges among the wedge's nodes
    middle = {frozenset(edge): 8 + k for k, edge in enumerate(FORMS["hexahedron"].edges)}
    ways = turned("hexahedron")
    rows = []
    for row in mesh.blocks[kind][:, places]:
        order = ways[rng.integers(len(ways))]
        between = [middle[frozenset(order[k] for k in edge)] for edge in FORMS["hexahedron"].edges] if kind == "wedge15" else []
        rows.append(row[[*order, *between]])
    return mesh, np.array(rows)


@pytest.mark.parametrize("kind", ["wedge", "wedge15"])
def test_a_body_of_collapsed_hexahedra_is_the_one_of_wedges_with_its_groups(kind, tmp_path):
    mesh, rows = collapsed_box(kind, (2, 1, 1), 1)
    hexahedra = "hexahedron" if kind == "wedge" else "hexahedron20"
    half = np.arange(len(rows)) < 2
    sets = {"near": [np.flatnonzero(half)], "far": [np.flatnonzero(~half)]}
    meshio.write(tmp_path / "mesh.inp", meshio.Mesh(mesh.nodes, [(hexahedra, rows)], cell_sets=sets))
    found = read_mesh(tmp_path / "mesh.inp")
    assert [*found.blocks] == [kind]
    assert [len(found.volumes[name][kind]) for name in ("near", "far")] == [2, len(rows) - 2]
    (remark,) = found.remarks
    assert remark.startswith(f"{len(rows)} elements of kind {hexahedra} repeat nodes, and are taken as what they are: {kind}.")
    assert ("make them stiffer" in remark) == (kind == "wedge15")
    one, other = (solid_matrices(element_blocks(each), len(mesh.nodes), 3) for each in (mesh, found))
    for name in ("scalar_mass", "first", "shear"):
        matrices = [getattr(each, name).toarray() for each in (one, other)]
        np.testing.assert_allclose(
            matrices[1], matrices[0], atol=1e-13 * np.abs(matrices[0]).max()
        )  # order of sums, digits of the file


def test_collapsed_hexahedra_of_8_nodes_have_the_same_matrices_as_elements_of_their_own(monkeypatch):
    """Their shape functions, those of the nodes that are one added up, are those of the wedge; so are their integrals by Gauss' points."""
    mesh, rows = collapsed_box("wedge", (1, 1, 1), 2)
    straight = SolidMesh(box("wedge", (1, 1, 1), (2.0, 0.5, 0.4)).nodes, mesh.blocks)
    wedges = solid_matrices(element_blocks(straight), len(mesh.nodes), 3)
    monkeypatch.setattr(solid_elements, "_refuse_degenerate", lambda *_: None)  # they are flat at the collapsed edge
    hexahedra = solid_matrices(element_blocks(SolidMesh(straight.nodes, {"hexahedron": rows})), len(mesh.nodes), 3)
    for name in ("scalar_mass", "first", "shear"):
        expected = getattr(wedges, name).toarray()
        np.testing.assert_allclose(getattr(hexahedra, name).toarray(), expected, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("kind", ["triangle", "triangle6"])
def test_quadrilaterals_with_a_collapsed_side_are_triangles(kind, tmp_path):
    mesh = rectangle(kind, (2, 1), 1.0, 0.4)
    places = [[0, 1, 2, 2], [0, 0, 1, 2], [0, 1, 1, 2], [0, 1, 2, 0]]
    sides = [[3, 4, 2, 5], [0, 3, 4, 5], [3, 1, 4, 5], [3, 4, 5, 0]]
    order = np.array([[*a, *b] for a, b in zip(places, sides, strict=True)] if kind == "triangle6" else places)
    quads = np.take_along_axis(mesh.blocks[kind], order[np.arange(len(mesh.blocks[kind])) % 4], axis=1)
    path = write_body(tmp_path, mesh, 'kind = "static"')
    expected = build(path)
    meshio.write(
        tmp_path / "body.vtu",
        meshio.Mesh(np.column_stack([mesh.nodes, 0 * mesh.nodes[:, 0]]), [("quad8" if kind == "triangle6" else "quad", quads)]),
    )
    assert [*read_mesh(tmp_path / "body.vtu").blocks] == [kind]
    same(expected, build(path), 1e-12)  # order of sums times the condition of the stiffness


def test_hexahedra_beside_their_collapsed_neighbours_are_one_body(tmp_path):
    """A file of one kind becomes one of two, and a collapsed quadrilateral names the wedges' triangular faces."""
    nodes = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1), (2, 0))])
    rows = np.array([[0, 1, 2, 3, 5, 6, 7, 8], [1, 4, 2, 2, 6, 9, 7, 7]])
    lids = np.array([[0, 1, 2, 3], [1, 4, 2, 2]])
    cells = [("hexahedron", rows), ("quad", lids)]
    meshio.write(tmp_path / "body.inp", meshio.Mesh(nodes, cells, cell_sets={"lid": [[], [0, 1]]}))
    path = tmp_path / "body.toml"
    path.write_text(
        """
units = "m-kg-s"
mesh.file = "body.inp"
material = { youngs_modulus = 1e9, density = 1000.0, poisson_ratio = 0.3 }
clamp.box = [0, 0, 0, 0, 1, 1]
interface_points.end.nodes = [1, 2, 6, 7]
pressure_surfaces.lid.group = "lid"
basis = { kind = "static" }
"""
    )
    model, body = build(path), discrete_body(path, BodyRecipe.read(path).file)
    assert {kind: len(block) for kind, block in body.mesh.blocks.items()} == {"hexahedron": 1, "wedge": 1}
    np.testing.assert_allclose(model.invariants.mass, 1500.0, rtol=1e-14)  # round-off, here and below
    np.testing.assert_allclose(model.surface_loads["lid"].force, [0, 0, 1.5], atol=1e-14)


PYRAMID, ODD = [0, 1, 2, 3, 4, 4, 4, 4], [0, 1, 2, 3, 4, 5, 6, 4]
CUBE20 = with_middles("hexahedron", [0, 1, 2, 2, 4, 5, 6, 6], [*CUBE])


@pytest.mark.parametrize(
    ("kind", "row", "message"),
    [
        ("hexahedron", PYRAMID, r"1 elements of kind hexahedron that repeat nodes as pyramids do"),
        ("wedge", [0, 1, 2, 0, 4, 5], r"elements of kind wedge that repeat nodes as pyramids do"),
        ("hexahedron", ODD, r"1 elements of kind hexahedron that repeat nodes in a way that leaves no element, the first round"),
        ("hexahedron", [0, 1, 0, 3, 4, 5, 6, 7], "in a way that leaves no element"),
        ("hexahedron", [0, 1, 1, 3, 4, 5, 6, 6], "in a way that leaves no element"),
        ("hexahedron", [0, 0, 0, 0, 4, 4, 4, 4], "in a way that leaves no element"),
        ("tetra", [0, 1, 2, 2], "elements of kind tetra that repeat nodes in a way"),
        ("hexahedron20", [*CUBE20[:10], 20, *CUBE20[11:]], "elements of kind hexahedron20 that repeat nodes in a way"),
        ("hexahedron20", [*CUBE20[:19], 20], "the node in the middle of a collapsed edge is then that of its end"),
        ("hexahedron20", [*range(19), 18], "leaves no element"),
        ("quad", [0, 1, 2, 1], r"elements of kind quad .* leaves no element"),
        ("quad", [0, 1, 1, 0], r"elements of kind quad .* leaves no element"),
        ("quad9", [0, 1, 2, 2, 4, 5, 2, 6, 7], r"elements of kind quad9 .* leaves no element"),
        ("triangle", [0, 1, 1], r"elements of kind triangle .* leaves no element"),
    ],
)
def test_nodes_repeated_otherwise_are_refused_by_kind_number_and_place(kind, row, message):
    points = np.vstack([CUBE, np.random.default_rng(1).uniform(0, 1, (20, 3))])
    with pytest.raises(InputError, match=message):
        uncollapsed(Path("body.vtu"), contents([(kind, [row])], points))
