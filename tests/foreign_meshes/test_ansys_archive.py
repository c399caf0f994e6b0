"""The reader of Ansys' archives (.cdb): fixed columns, bricks whose corners fall together, components, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from preprocessing import build
from preprocessing.foreign_files.ansys_archive import ansys_mesh
from preprocessing.foreign_files.contents import MeshContents
from tests.foreign_meshes.ansys_files import component, element_block, node_block
from tests.foreign_meshes.sizes import size
from tests.models.solid_bodies import box
from toolkit.foundation.errors import InputError

HEAD = "/COM,ANSYS RELEASE 2019 R2\n/PREP7\n/TITLE,bar\n*SET,_RETURN ,  0.0\n"


def read(folder: Path, text: str, leave_out: frozenset[str] = frozenset()) -> MeshContents:
    (folder / "body.cdb").write_text(text)
    return ansys_mesh(folder / "body.cdb", leave_out)


CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
SHAPES = {
    "hexahedron": ([1, 2, 3, 4, 5, 6, 7, 8], 1.0),
    "wedge": ([1, 2, 3, 3, 5, 6, 7, 7], 0.5),
    "tetra": ([1, 2, 3, 3, 5, 5, 5, 5], 1 / 6),
    "pyramid": ([1, 2, 3, 4, 5, 5, 5, 5], 1 / 3),
}
"""Kind -> nodes of a SOLID185 that is one, and its volume."""


@pytest.mark.parametrize("kind", SHAPES)
def test_a_brick_whose_corners_fall_together_is_what_it_looks_like(tmp_path, kind):
    nodes, volume = SHAPES[kind]
    found = read(tmp_path, f"{HEAD}ET,        1,185\n{node_block(CUBE)}{element_block((1, nodes))}")
    assert [each for each, _ in found.cells] == [kind]
    assert size(found.points, dict(found.cells)) == pytest.approx(volume)


EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
MIDDLES = {
    "hexahedron20": EDGES,
    "wedge15": [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
    "tetra10": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
}
CORNERS = {"hexahedron20": 8, "wedge15": 6, "tetra10": 4}


@pytest.mark.parametrize("kind", MIDDLES)
def test_middle_nodes_of_such_a_quadratic_brick_stay_between_their_corners(tmp_path, kind):
    corners = SHAPES[kind.rstrip("0123456789")][0]
    places = [*CUBE]
    nodes = list(corners)
    known: dict[tuple[int, ...], int] = {}
    for a, b in EDGES:
        ends = tuple(sorted((corners[a], corners[b])))
        if ends[0] != ends[1] and ends not in known:
            places.append((CUBE[ends[0] - 1] + CUBE[ends[1] - 1]) / 2)
            known[ends] = len(places)
        nodes.append(known.get(ends, ends[0]))
    found = read(tmp_path, f"{HEAD}ET,1,SOLID186\n{node_block(np.array(places))}{element_block((1, nodes))}")
    ((each, block),) = found.cells
    assert each == kind
    for place, ends in enumerate(MIDDLES[kind], CORNERS[kind]):
        np.testing.assert_allclose(found.points[block[:, place]], found.points[block[:, ends]].mean(axis=1), atol=1e-12)


BAR = box("hexahedron", (4, 1, 1), (4.0, 1.0, 0.5))
BLOCKS = [(1, (row + 1).tolist()) for row in BAR.blocks["hexahedron"]]
ENDS = {name: (np.flatnonzero(np.isclose(BAR.nodes[:, 0], x)) + 1).tolist() for name, x in (("ROOT", 0.0), ("TIP", 4.0))}


@pytest.mark.usefixtures("read_here")
def test_a_bar_has_its_mass_and_its_tip(tmp_path):
    groups = "".join(component(name, "NODE", *labels) for name, labels in ENDS.items())
    (tmp_path / "body.cdb").write_text(f"{HEAD}ET,1,185\n{node_block(BAR.nodes)}{element_block(*BLOCKS)}{groups}FINISH\n")
    (tmp_path / "body.toml").write_text(
        'units = "m-kg-s"\nmesh = { file = "body.cdb" }\nbasis = { kind = "static" }\nclamp = { group = "ROOT" }\n'
        'material = { youngs_modulus = 210e9, density = 7800.0, poisson_ratio = 0.3 }\ninterface_points = { tip = { group = "TIP" } }\n'
    )
    model = build(tmp_path / "body.toml")
    middle = BAR.nodes[np.array(ENDS["TIP"]) - 1].mean(axis=0)
    assert model.invariants.mass == pytest.approx(7800 * 2.0, rel=1e-12)
    np.testing.assert_allclose(model.interfaces["tip"].position[0, :, 0], middle, atol=1e-9)


def test_components_list_labels_and_ranges(tmp_path):
    parts = component("SOME", "ELEM", 101, 103, -104) + component("POINTS", "NODE", 2, -4, 9)
    found = read(tmp_path, f"{HEAD}ET,1,185\n{node_block(BAR.nodes)}{element_block(*BLOCKS)}{parts}")
    groups = dict(found.groups)
    assert np.concatenate([nodes for _, nodes in groups["SOME"]]).tolist() == BAR.blocks["hexahedron"][[0, 2, 3]].tolist()
    assert found.labels[groups["POINTS"][0][1].ravel()].tolist() == [2, 3, 4, 9]


def test_shells_beside_the_body_are_refused_by_name_or_left_out_on_purpose(tmp_path):
    text = f"{HEAD}ET,1,185\nET,2,181\n{node_block(BAR.nodes)}{element_block(*BLOCKS, (2, [1, 2, 3, 4]))}"
    text += component("ALL", "ELEM", 101, -105)
    with pytest.raises(InputError, match=r'has 1 times SHELL181.*leave_out = \["SHELL181"\]'):
        read(tmp_path, text)
    found = read(tmp_path, text, frozenset({"SHELL181"}))
    assert [(each.what, each.number) for each in found.left_out] == [("SHELL181", 1)]
    assert "The component 'ALL' has 1 elements that are no part of the body." in found.remarks
    with pytest.raises(InputError, match=r"names BEAM188, which .* does not hold"):
        read(tmp_path, text, frozenset({"SHELL181", "BEAM188"}))


def test_types_stand_in_a_block_too_and_nodes_without_a_solid_model(tmp_path):
    types = "ETBLOCK,        1,        1\n(2i9,19a9)\n        1      185        0        2\n       -1\n"
    rows = "\n".join(f"{k:8d}" + "".join(f"{x:16.9E}" for x in place) for k, place in enumerate(CUBE, 1))
    nodes = f"NBLOCK,3,,8,8\n(1i8,3e16.9)\n{rows}\n      -1\n"
    found = read(tmp_path, HEAD + types + nodes + element_block((1, [1, 2, 3, 4, 5, 6, 7, 8])))
    assert size(found.points, dict(found.cells)) == pytest.approx(1.0)


def test_plane_elements_are_read_and_those_with_two_equal_corners_are_triangles(tmp_path):
    text = f"{HEAD}ET,1,182\nKEYOPT,1,3,3\n{node_block(CUBE[:4])}{element_block((1, [1, 2, 3, 3]), (1, [1, 3, 4, 4]))}"
    found = read(tmp_path, text)
    assert [(kind, nodes.tolist()) for kind, nodes in found.cells] == [("triangle", [[0, 1, 2], [0, 2, 3]])]


TYPE = f"{HEAD}ET,1,185\n"
NODES, ELEMENTS = node_block(CUBE), element_block((1, [1, 2, 3, 4, 5, 6, 7, 8]))
WRONG = {
    "nothing": ("/PREP7\nNBLOCK,6,SOLID", "line 2: a block begins without a format"),
    "no elements": (TYPE + NODES, "no EBLOCK with elements"),
    "no end": (TYPE + NODES + ELEMENTS[:-10], "a block has no end"),
    "fewer nodes": (TYPE + NODES.replace("         8\n", "         9\n", 1) + ELEMENTS, "NBLOCK has not as many nodes as it says"),
    "fewer elements": (TYPE + NODES + ELEMENTS.replace("SOLID,1,1", "SOLID,2,2"), "EBLOCK has not as many elements as it says"),
    "a node that is not there": (TYPE + NODES + element_block((1, [1, 2, 3, 4, 5, 6, 7, 9])), "a node that the file does not hold"),
    "no type": (HEAD + NODES + ELEMENTS, "an element is of a type that no ET defines"),
    "single nodes": (TYPE + NODES + "N,9,1,2,3\n" + ELEMENTS, "line 17: the command N gives single nodes"),
    "merged nodes": (TYPE + NODES + ELEMENTS + "NUMMRG,NODE\n", "the command NUMMRG changes nodes or elements"),
    "ties": (TYPE + NODES + ELEMENTS + "CP,1,UX,1,2\nCP,2,UX,3,4\n", r'has 2 times CP.*leave_out = \["CP"\]'),
    "solver's elements": (TYPE + NODES + ELEMENTS.replace("19,SOLID", "10,"), "EBLOCK without SOLID"),
    "a node twice": (TYPE + NODES + element_block((1, [1, 2, 3, 4, 5, 6, 7, 1])), "a hexahedron has a node twice"),
    "corners that give nothing": (TYPE + NODES + element_block((1, [1, 2, 3, 4, 5, 6, 7, 7])), "gives no wedge, tetrahedron or pyramid"),
    "missing middles": (
        f"{HEAD}ET,1,186\n{NODES}{element_block((1, [1, 2, 3, 4, 5, 6, 7, 8, 1, 2]))}",
        "type 186 lacks some of its nodes",
    ),
    "axisymmetric": (
        f"{HEAD}ET,1,182\nKEYOPT,1,3,1\n{NODES}{element_block((1, [1, 2, 3, 4]))}",
        r"type 182 have KEYOPT\(3\)",
    ),
    "a word": (TYPE + NODES.replace("1.0000000000000E+00", "1.0000000000x00E+00", 1) + ELEMENTS, "a word is no number|no single number"),
    "numbers of no component": (TYPE + NODES + ELEMENTS + component("A", "NODE", 1, -3, -4), "a range without a start"),
}  # fmt: skip


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_not_read_is_refused(tmp_path, kind):
    text, message = WRONG[kind]
    with pytest.raises(InputError, match=message):
        read(tmp_path, text)
