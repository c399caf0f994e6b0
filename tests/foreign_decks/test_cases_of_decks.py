"""Decks in the words of several programs: one bar written in many ways, and bodies whose frequencies CalculiX says."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from preprocessing import build
from preprocessing.mesh.mesh_file import read_mesh
from tests.models.solid_bodies import frequencies
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.composition import read_composition

DECKS = Path(__file__).parents[1] / "data" / "foreign_files" / "decks"
DENSITY = 7800.0
pytestmark = pytest.mark.usefixtures("all_read_here")


class Right(NamedTuple):
    """What is right of a body, from closed forms."""

    mass: float
    centre: tuple[float, float, float] | None
    tip: tuple[float, float, float]


def mean_of_face(*corners: tuple[float, float, float]) -> tuple[float, float, float]:
    """The area mean of a face that is curved as its four corners say: the sum over many small parallelograms."""
    s, t = np.meshgrid(*2 * [(np.arange(400) + 0.5) / 400])
    s, t = s[..., None], t[..., None]
    a, b, c, d = np.array(corners)
    places = (1 - s) * (1 - t) * a + s * (1 - t) * b + s * t * c + (1 - s) * t * d
    areas = np.linalg.norm(np.cross((1 - t) * (b - a) + t * (c - d), (1 - s) * (d - a) + s * (c - b)), axis=-1)
    mean = (areas[..., None] * places).sum(axis=(0, 1)) / areas.sum()
    return float(mean[0]), float(mean[1]), float(mean[2])


BAR = Right(15600.0, (2.0, 0.5, 0.25), (4.0, 0.5, 0.25))
HALF = BAR._replace(tip=(2.0, 0.5, 0.25))
WHOLE_ELEMENT = BAR._replace(tip=(3.5, 0.5, 0.25))  # the tip is all of the last hexahedron: the mean over its volume
CASES = {
    "plain": BAR,
    "elset-of-second-block": WHOLE_ELEMENT,
    "nset-twice": WHOLE_ELEMENT,
    "nset-on-node": BAR,
    "reference-point": BAR,
    "instance-moved": Right(15600.0, (9.5, 2.0, 0.25), (9.5, 4.0, 0.25)),
    "node-system-c": Right(
        DENSITY * 0.5 * 4 * 1.5 * np.sin(np.radians(22.5)), None, (0.0, 1.5, 0.25)
    ),  # four trapezoids of a ring
    "comment-in-elements": HALF,
    "generate-no-increment": BAR,
    "lower-case-type": BAR,
    "set-of-sets": BAR,
    "mass-element": Right(16100.0, tuple((15600 * np.array([2, 0.5, 0.25]) + 500 * np.array([4, 0, 0])) / 16100), BAR.tip),
    "instance-lines-only-part": HALF,
    "freecad": BAR,
    "freecad-two-kinds": Right(15600.0 + DENSITY / 3, None, BAR.tip),  # a wedge of heights 0.5, 0.5, 1 over half a square metre
    "elset-before-element": BAR,
    "include": BAR,
    # Node 5 goes from x = 4 to 6, where the last place counts: 2 m times its share of the volume's change, the integral of dN_5 / dx.
    "element-twice-overwritten": Right(
        15600.0 + DENSITY * 2 * 0.125, None, mean_of_face((6, 0, 0), (4, 1, 0), (4, 1, 0.5), (4, 0, 0.5))
    ),
    "blank-coordinates": BAR,
    "keyword-continued": BAR,
    "mirrored-hexes": BAR,
    "c3d20-right-order": BAR,
    "c3d10": BAR,
    "elset-alone": BAR,
    "fine-comment": HALF,
}
"""Folder -> what is right."""
REFUSED = {
    "two-parts": "line 7: the deck has 1 element of type S4R",
    "two-solid-parts": "consists of 2 parts that share no nodes",
    "two-parts-alike": r"has 2 parts and no \*ASSEMBLY",
    "shell-and-beam-dropped": "line 32: the deck has 4 elements of type B31",
    "c3d10-gmsh-order": "nodes in the middle of other edges",
    "mixed-orders": "have a node in their middle in some of their elements only",
}
"""Folder -> what the error says."""


def copied(case: str, folder: Path) -> Path:
    """body.toml of a case in a folder of its own."""
    shutil.copytree(DECKS / case, folder, dirs_exist_ok=True)
    return folder / "body.toml"


@pytest.mark.parametrize("case", CASES)
def test_a_body_is_what_its_deck_says(case, tmp_path):
    model, right = build(copied(case, tmp_path)), CASES[case]
    assert model.invariants.mass == pytest.approx(right.mass, rel=1e-12)
    if right.centre is not None:
        np.testing.assert_allclose(model.invariants.first_moment[:, 0] / right.mass, right.centre, rtol=1e-12)
    curved = case == "element-twice-overwritten"  # the quadrature of its face is not exact
    np.testing.assert_allclose(model.interfaces["tip"].here[0][:, 0], right.tip, rtol=3e-3 if curved else 1e-9, atol=1e-12)


def test_every_case_is_tried():
    assert {path.name for path in DECKS.iterdir() if path.is_dir()} == {*CASES, *REFUSED}


@pytest.mark.parametrize("case", REFUSED)
def test_a_deck_that_is_no_body_is_refused_by_what_it_holds(case, tmp_path):
    with pytest.raises(InputError, match=REFUSED[case]):
        build(copied(case, tmp_path))


@pytest.mark.parametrize(("case", "left_out"), [("two-parts", {"S4R": 1}), ("shell-and-beam-dropped", {"S4R": 4, "B31": 4})])
def test_what_is_left_out_on_purpose_is_told(case, left_out, tmp_path):
    path = copied(case, tmp_path)
    text = path.read_text()
    path.write_text(text.replace('"body.inp" }', f'"body.inp", leave_out = {[*left_out]} }}'))
    model = build(path)
    assert model.invariants.mass == pytest.approx(15600.0, rel=1e-12)
    assert {each.what: each.number for each in read_composition(model.composition, 3).left_out} == left_out


PLAIN = """units = "mm-t-s"
mesh = { file = "body.inp" }
material = { youngs_modulus = 70e3, density = 2.7e-9, poisson_ratio = 0.33 }
clamp = { group = "root" }
interface_points = { tip = { group = "tip", tie = "TIE" } }
basis = { BASIS }
"""
BY_CALCULIX = (666.8313, 666.9821, 2403.568)
"""The lowest frequencies in Hz of the deck by CalculiX 2.20, whose C3D20 is integrated as ours is."""
BASES = {
    # All digits that it prints: four modes of the body as it is clamped, with nothing that holds its tip.
    ("averaged", 'kind = "eigenmodes", count = 4'): 1e-6,
    # Modes with the tip held and its motions as a rigid face: few shapes are too stiff.
    ("rigid", 'kind = "craig-bampton", count = 4'): 4e-3,
}
"""Tie and basis -> how far the frequencies are above."""


@pytest.mark.parametrize("basis", BASES, ids=lambda basis: basis[0])
def test_the_frequencies_are_those_of_calculix(basis, tmp_path):
    shutil.copy(DECKS / "plain.inp", tmp_path / "body.inp")
    (tmp_path / "body.toml").write_text(PLAIN.replace("TIE", basis[0]).replace("BASIS", basis[1]))
    model = build(tmp_path / "body.toml")
    assert model.invariants.mass == pytest.approx(2.7e-9 * (100 * 10 * 10 + 3 * 12.5 * 10 * 20), rel=1e-12)
    found = frequencies(model)[:3]
    np.testing.assert_allclose(found, BY_CALCULIX, rtol=BASES[basis])
    assert np.all(found > (1 - 1e-6) * np.array(BY_CALCULIX))


RIB = "9, 35, 47, 48, 36, 105"  # the first element of the rib
ROOT = "*NSET, NSET=root\n1, 4, 5, 8, 12, 16, 17, 20\n"
TIP = "*NSET, NSET=tip\n"
SECOND = "\n*ELEMENT, TYPE=C3D20, ELSET="
SPELLINGS = {
    "a comment among the elements": {f"\n{RIB}": f"\n** rib\n{RIB}"},
    "a set in two blocks": {ROOT: "*NSET, NSET=root\n1, 4, 5, 8\n*NSET, NSET=root\n12, 16, 17, 20\n"},
    "a set of sets": {ROOT: "*NSET, NSET=a\n1, 4, 12, 17, 20\n*NSET, NSET=b\n5, 8, 16\n*NSET, NSET=root\na,\nb,\n"},
    "a set on the second block": {
        "C3D20, ELSET=Eall": "C3D20",
        f"\n{RIB}": f"{SECOND}rib\n{RIB}",
        TIP: f"*ELSET, ELSET=Eall, GENERATE\n1,11,1\n{TIP}",
    },
    "one set on both blocks": {f"\n{RIB}": f"{SECOND}Eall\n{RIB}"},
    "a set of one set": {
        "ELSET=Eall\n1": "ELSET=bar\n1",
        f"\n{RIB}": f"{SECOND}rib\n{RIB}",
        TIP: f"*ELSET, ELSET=Eall\nbar,\nrib,\n*ELSET, ELSET=other\nrib,\n{TIP}",
    },
    "a range without a step": {TIP: f"*ELSET, ELSET=Eone, GENERATE\n1, 11\n{TIP}"},
    "two blocks of nodes": {"NSET=Nall": "NSET=N1", "\n105, 37": "\n*NODE, NSET=N2\n105, 37"},
    "a reference node": {
        "*MATERIAL": "*NODE, NSET=ref\n900, 100., 5., 5.\n901, 100., 5., 5.\n"
        "*RIGID BODY, NSET=tip, REF NODE=900, ROT NODE=901\n*MATERIAL"
    },
}
"""Another spelling of the same body -> what is written instead of what."""


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_another_spelling_is_the_same_body(spelling, tmp_path):
    text = (DECKS / "plain.inp").read_text()
    plain = read_mesh(DECKS / "plain.inp")
    for old, new in SPELLINGS[spelling].items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    (tmp_path / "body.inp").write_text(text)
    found = read_mesh(tmp_path / "body.inp")
    assert np.array_equal(found.nodes, plain.nodes)
    assert found.blocks.keys() == plain.blocks.keys() == {"hexahedron20"}
    assert np.array_equal(found.blocks["hexahedron20"], plain.blocks["hexahedron20"])
    for name in ("root", "tip", "Eall"):
        assert np.array_equal(found.groups[name], plain.groups[name])


def test_sets_outside_of_an_included_file_count(tmp_path):
    text = (DECKS / "plain.inp").read_text()
    cut = text.index("*NSET, NSET=root")
    (tmp_path / "mesh_only.inp").write_text(text[:cut])
    (tmp_path / "body.inp").write_text(f"*INCLUDE, INPUT=mesh_only.inp\n{text[cut:]}")
    found, plain = read_mesh(tmp_path / "body.inp"), read_mesh(DECKS / "plain.inp")
    assert found.groups.keys() == plain.groups.keys()
    assert all(np.array_equal(found.groups[name], plain.groups[name]) for name in plain.groups)


def bar_with_ends(*ends: str) -> str:
    """A deck of ten cubes of 10 mm in a row, with more lines at its end."""
    nodes = [f"{4 * i + 2 * j + k + 1}, {10 * i}, {10 * j}, {10 * k}" for i in range(11) for j in (0, 1) for k in (0, 1)]
    cubes = [", ".join(str(4 * i + n) for n in (1, 5, 7, 3, 2, 6, 8, 4)) for i in range(10)]
    elements = [f"{i + 1}, {cube}" for i, cube in enumerate(cubes)]
    return "\n".join(["*HEADING", "bar", "*NODE", *nodes, "*ELEMENT, TYPE=C3D8, ELSET=Eall", *elements, *ends, ""])


def test_shells_that_name_ends_are_groups_of_these(tmp_path):
    shells = ["*ELEMENT, TYPE=S4, ELSET=root", "101, 1, 3, 4, 2", "*ELEMENT, TYPE=S4, ELSET=tip", "102, 41, 43, 44, 42"]
    both = ["*ELSET, ELSET=ends", "101", "*ELSET, ELSET=ends", "102"]
    (tmp_path / "body.inp").write_text(bar_with_ends(*shells, *both))
    mesh = read_mesh(tmp_path / "body.inp")
    assert {*mesh.nodes[mesh.groups["root"], 0]} == {0.0}
    assert {*mesh.nodes[mesh.groups["tip"], 0]} == {100.0}
    assert sorted(mesh.nodes[mesh.groups["ends"], 0]) == 4 * [0.0] + 4 * [100.0]
    assert {each.what: each.number for each in mesh.left_out} == {"S4": 2}


def test_parts_with_numbers_alike_are_not_mixed():
    with pytest.raises(InputError, match=r"has 2 parts and no \*ASSEMBLY"):
        read_mesh(DECKS / "two_parts.inp")


def test_what_netgen_writes_is_read_with_its_faces_left_out():
    """The volume of its tetrahedra is that within its faces, by the divergence theorem; its coordinates have eight digits."""
    blocks = (DECKS / "netgen_abaqus.inp").read_text().split("*Element, type=")
    nodes = _rows(blocks[0].split("*Node")[1])
    places = dict(zip(nodes[:, 0].astype(int), nodes[:, 1:], strict=True))
    faces = np.concatenate([_rows(block.split("\n", 1)[1]) for block in blocks if block.startswith("CPS3")]).astype(int)
    within = np.linalg.det([[places[node] for node in face[1:]] for face in faces.tolist()]).sum() / 6
    mesh = read_mesh(DECKS / "netgen_abaqus.inp")
    edges = mesh.nodes[mesh.blocks["tetra"]][:, 1:] - mesh.nodes[mesh.blocks["tetra"]][:, :1]
    assert np.abs(np.linalg.det(edges)).sum() / 6 == pytest.approx(abs(within), rel=1e-6)
    assert {each.what: each.number for each in mesh.left_out} == {"CPS3": len(faces)}


def _rows(text: str) -> np.ndarray:
    """Numbers between commas."""
    return np.array([[float(field) for field in line.split(",")] for line in text.split("\n") if line.strip()[:1].isdigit()])
