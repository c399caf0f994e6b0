"""Groups of elements that a solid is cut into: what is no chain of pieces is refused in words."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from preprocessing.builders.build_model import read_recipe
from preprocessing.builders.cut_mesh import cut_mesh
from preprocessing.builders.named_mesh import named_mesh
from preprocessing.reduction.ties import freedom
from tests.models.solid_bodies import box, rectangle, write_body
from tests.models.solid_pieces import write_bar
from toolkit.foundation.errors import InputError

pytestmark = pytest.mark.usefixtures("read_here")


@pytest.fixture
def cells(tmp_path):
    """A bar of four by three elements, whose groups are given by the middle of their elements."""

    def write(pieces, more="", **groups):
        path, mesh = write_bar(tmp_path, 4, kind="hexahedron"), box("hexahedron", (4, 3, 1), (4.0, 3.0, 1.0))
        blocks = mesh.blocks["hexahedron"]
        x, y = mesh.nodes[blocks].mean(axis=1)[:, :2].T
        sets = {name: [np.flatnonzero(which(x, y))] for name, which in groups.items()}
        ends = {name: mesh.groups[name] for name in ("left", "right")}
        ends["corner"] = np.flatnonzero((mesh.nodes[:, 0] == 2) & (mesh.nodes[:, 1] == 1.5))
        meshio.write(tmp_path / "bar.inp", meshio.Mesh(mesh.nodes, [("hexahedron", blocks)], cell_sets=sets, point_sets=ends))
        text = path.read_text()
        path.write_text(text[: text.index("pieces =")] + f"pieces.groups = {pieces}\n" + more)
        return path

    return write


def chain(path):
    recipe = read_recipe(path)
    return cut_mesh(named_mesh(path, recipe.file))


HALVES = {"one": lambda x, _: x < 2, "two": lambda x, _: x > 2}


def test_pieces_are_put_in_a_row_from_the_clamp_on(cells):
    """Whatever the order of their names; the clamp is rigid, and the point on it is the end there."""
    found = chain(cells(["two", "one"], **HALVES))
    assert [piece.group for piece in found.pieces] == ["one", "two"]
    assert [end.point for end in found.ends] == ["root", "", "tip"]
    assert found.ends[0].region.tie == "rigid"
    assert set(found.ends[1].nodes) == set(np.intersect1d(found.pieces[0].nodes, found.pieces[1].nodes))


def test_a_point_on_a_face_is_that_end(cells):
    path = cells(["one", "two"], 'interface_points.middle = { box = [2, -1.5, -0.5, 2, 1.5, 0.5], tie = "rigid" }\n', **HALVES)
    found = chain(path)
    assert found.ends[1].point == "middle"
    assert found.ends[1].region.tie == "rigid"
    mesh = found.named.mesh
    assert freedom(mesh, found.named.clamped, found.named.ties(mesh.nodes)).rigid == ("middle",)


L_SHAPED = {"one": lambda x, y: (x < 2) & (y < -0.5), "two": lambda x, y: (x < 2) & (y > -0.5), "three": lambda x, _: x > 2}
LUMPS = {"one": lambda x, _: (x < 1) | (x > 3), "two": lambda x, _: (x > 1) & (x < 3)}
RING = {
    "one": lambda x, y: (abs(y) > 0.5) | (x < 1),
    "two": lambda x, y: (abs(y) < 0.5) & (x > 3),
    "three": lambda x, y: (abs(y) < 0.5) & (x > 1) & (x < 3),
}
EDGES = {
    "a": lambda x, y: (x < 2) & (y < -0.5),
    "b": lambda x, y: (x > 2) & (y > -0.5),
    "c": lambda x, y: (x < 2) & (y > -0.5),
    "d": lambda x, y: (x > 2) & (y < -0.5),
}


@pytest.mark.parametrize(
    ("pieces", "groups", "message"),
    [
        (["one", "tow"], HALVES, r"group 'tow' is not in the mesh.*did you mean 'two'"),
        (["one", "left"], HALVES, r"group 'left' has no elements of the volume; groups with such elements: 'one', 'two'"),
        (["one"], HALVES, r"cut into two different groups at least, and here are 'one'"),
        (["one", "one"], HALVES, r"cut into two different groups at least"),
        (
            ["one", "two"],
            {**HALVES, "two": lambda x, _: x > 3},
            r"3 elements are in no group of 'one', 'two', the first round \(2\.5,",
        ),
        (
            ["one", "two"],
            {**HALVES, "two": lambda x, _: x > 1},
            r"3 elements are in more than one group of .*, the first round \(1\.5,",
        ),
        (["one", "two"], LUMPS, r"group 'one' consists of 2 lumps that share no nodes"),
        (["one", "two", "three"], RING, r"groups 'one' and 'two' meet in 2 faces and not in one"),
        (["a", "b", "c", "d"], EDGES, r"groups 'a' and 'b' meet in nodes, but in no whole face of an element"),
        (["one", "two", "three"], L_SHAPED, r"the clamp and the face between 'one' and 'two' share nodes"),
    ],
)
def test_what_are_no_pieces_is_refused(cells, pieces, groups, message):
    with pytest.raises(InputError, match=message):
        chain(cells(pieces, **groups))


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("interface_points.grip.nodes = [0, 1]\n", r"the clamp and interface point 'grip' share nodes"),
        ('interface_points.grip.group = "corner"\n', r"the face between 'one' and 'two' and interface point 'grip' share nodes"),
        ("interface_points.grip.box = [1, -1.5, 0.5, 1, 1.5, 0.5]\n", r"group 'one' has 3 ends .* instead of two"),
        ("interface_points.again.group = 'left'\n", r"interface points 'root' and 'again' are at the same nodes, the clamp"),
        ('basis.kind = "static"\n', r"\[pieces\] keep all motions of their ends"),
    ],
)
def test_points_and_tables_that_pieces_cannot_have_are_refused(cells, more, message):
    with pytest.raises(InputError, match=message):
        chain(cells(["one", "two"], more, **HALVES))


def test_pieces_need_a_clamp_and_a_point_at_the_other_end(cells):
    path = cells(["one", "two"], **HALVES)
    text = path.read_text()
    for left_out, message in (
        ('clamp.group = "left"\n', "frame needs a place|begin at a clamp"),
        (
            'interface_points.tip.group = "right"\n',
            r"group 'two' has 1 ends .* instead of two.*name an interface point at a free end",
        ),
    ):
        path.write_text(text.replace(left_out, ""))
        with pytest.raises(InputError, match=message):
            chain(path)


def test_solids_in_the_plane_have_no_pieces(tmp_path):
    path = write_body(tmp_path, rectangle("quad", (2, 1), 1.0, 0.2), more="")
    text = path.read_text()
    path.write_text(text[: text.index("[basis]")] + '[pieces]\ngroups = ["one", "two"]\n')
    with pytest.raises(InputError, match=r"pieces are cut out of spatial meshes. Leave \[pieces\] out"):
        chain(path)
