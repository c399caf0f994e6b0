"""Bulk data of Nastran: small files with values from outside, and what is refused or told by its name and line."""

from __future__ import annotations

import shutil
from pathlib import Path

import meshio
import numpy as np
import pytest

from preprocessing import build
from preprocessing.foreign_files.contents import MeshContents
from preprocessing.foreign_files.included_files import drawn_on
from preprocessing.foreign_files.nastran.bulk_file import read_bulk
from preprocessing.foreign_files.nastran.lines import CARRYING, OTHERS, TAKEN, WHY, real_numbers, whole_numbers
from preprocessing.mesh.mesh_file import read_mesh
from tests.models.solid_bodies import box
from toolkit.foundation.errors import InputError

FILES = Path(__file__).parents[1] / "data" / "foreign_files" / "nastran"
BAR = (15600.0, [2, 0.5, 0.25])
BARS = ["plain", "blank-zero", "free-field", "large-chexa", "no-begin-bulk", "exponents", "include-outer", "chexa20", "conm2"]
LONG_BAR = (7800.0 * 10_000, [50, 5, 5])
BODIES = {
    **dict.fromkeys(BARS, BAR),
    "include": LONG_BAR,
    "mixed-formats": LONG_BAR,
    "cord2c": (8954.7923173431, None),  # four sectors of a ring between radii 1 and 2: 0.5 * 4 * 1.5 sin(22.5 deg) m3
    "cp-cylindrical": (7800.0 * 10 * 10 * 0.5 * (50**2 - 40**2) * np.sin(np.radians(9)), None),
}
"""File -> mass and centre: closed forms, and pyNastran 1.4.1."""


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("name", BODIES)
def test_the_body_has_the_mass_and_centre_of_the_file(name, tmp_path):
    for path in FILES.iterdir():
        shutil.copy(path, tmp_path)
    left_out = ["CONM2"] if name == "conm2" else []
    mesh = read_mesh(tmp_path / f"{name}.bdf")
    low = np.flatnonzero(mesh.nodes[:, 0] < mesh.nodes[:, 0].min() + 1e-9 * mesh.size)
    (tmp_path / "body.toml").write_text(
        f'units = "m-kg-s"\nmesh = {{ file = "{name}.bdf", leave_out = {left_out} }}\nclamp = {{ nodes = {low.tolist()} }}\n'
        'material = { youngs_modulus = 210e9, density = 7800.0, poisson_ratio = 0.3 }\nbasis = { kind = "full" }\n'
    )
    found = build(tmp_path / "body.toml").invariants
    mass, centre = BODIES[name]
    np.testing.assert_allclose(found.mass, mass, rtol=1e-7)
    if centre is not None:
        np.testing.assert_allclose(found.first_moment[:, 0] / found.mass, centre, rtol=1e-7)


def test_the_process_that_reads_has_memory_enough():
    """It is bounded to a gigabyte more than the file is long."""
    mesh = read_mesh(FILES / "include.bdf")
    assert {kind: len(block) for kind, block in mesh.blocks.items()} == {"hexahedron": 10}


def read(folder: Path, text: str, *leave_out: str) -> MeshContents:
    (folder / "body.bdf").write_text(text)
    return read_bulk(folder / "body.bdf", frozenset(leave_out))


CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
GRID = "".join(f"GRID,{k + 1},,{x}.,{y}.,{z}.\n" for k, (x, y, z) in enumerate(CORNERS))
CUBE = GRID + "CHEXA,1,1,1,2,3,4,5,6\n,7,8\n"
PLATE = GRID + "CQUAD4,1,1,1,2,3,4\n"


FORMATS = {
    "small, then large": ["CHEXA   1       1       1       2       3       4       5       6       +A", "*A      7               8"],
    "large, then small": ["CHEXA*  1               1               1               2", "*       3               4               5"
                          "               6", "+       7       8"],
    "large half, then small": ["CHEXA*  1               1               1               2               *X",
                               "+X      7       8"],
    "free, then small": ["CHEXA,1,1,1,2,3,4,5,6,+", "+       7       8"],
    "mark in column 74": ["CHEXA   1       1       1       2       3       4       5       6       QED12", "+ED12   7       8"],
    "marks of all lines": ["CHEXA   1       1       1       2       3       4       5       6       LINE0007", "        7       8"],
    "name in the middle": ["  CHEXA 1       1       1       2       3       4       5       6", "        7       8"],
}  # fmt: skip


@pytest.mark.parametrize("kind", FORMATS)
def test_lines_of_one_card_may_have_formats_of_their_own(kind, tmp_path):
    text = GRID + "\n".join(FORMATS[kind]) + "\n"
    if kind == "large half, then small":  # the other half of the first line is blank, so that corners are missing
        with pytest.raises(InputError, match="CHEXA is read with 8 or 20 nodes"):
            read(tmp_path, text)
        return
    assert [(name, nodes.tolist()) for name, nodes in read(tmp_path, text).cells] == [("hexahedron", [[*range(8)]])]


def test_a_mass_stands_where_its_offset_puts_it_with_the_inertia_of_its_axes(tmp_path):
    """Axes turned by 90 degrees about z, and a product of inertia that counts as an integral."""
    text = CUBE + "CORD2R,4,,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\nCONM2,9,7,4,5.,.1,.2,.3,,\n,1.,.25,2.,.125,.5,3.\n"
    (mass,) = read(tmp_path, text).masses
    np.testing.assert_allclose(mass.place, [1 - 0.2, 1 + 0.1, 1 + 0.3])  # x of the mass lies along y, its y along -x
    np.testing.assert_allclose(mass.inertia, [2.0, 1.0, 3.0, 0.25, 0.5, -0.125], atol=1e-15)  # xy' = -xy, xz' = -yz, yz' = xz
    assert (mass.mass, mass.rigid, mass.carriers.tolist()) == (5.0, True, [6])
    assert "CONM2" in mass.source
    assert "line 13" in mass.source


def test_parameters_that_multiply_masses_are_told(tmp_path):
    found = read(tmp_path, "PARAM,WTMASS,.5\nBEGIN BULK\n" + CUBE + "CONM2,9,7,,5.\n")
    assert found.masses[0].mass == 2.5
    assert "WTMASS" in found.remarks[0]


def test_faces_without_a_property_name_places_and_others_are_refused(tmp_path):
    faces = CUBE + "CQUAD4,5,7,5,6,7,8\nCBAR,6,8,1,2,0.,0.,1.\n"
    found = read(tmp_path, faces)
    groups = {name: [(kind, nodes.tolist()) for kind, nodes in elements] for name, elements in found.groups}
    assert groups["pid 7"] == [("quad", [[4, 5, 6, 7]])]
    assert groups["pid 8"] == [("line", [[0, 1]])]
    assert [(each.what, each.number) for each in found.left_out] == [("CQUAD4", 1), ("CBAR", 1)]
    assert [kind for kind, _ in found.cells] == ["hexahedron"]
    with pytest.raises(InputError, match=r'1 CQUAD4, the first in .*line 11\..*leave_out = \["CQUAD4"\]'):
        read(tmp_path, faces + "PSHELL,7,1,.1\n")
    with pytest.raises(InputError, match="1 CTRIA3"):
        read(tmp_path, CUBE + "CTRIA3,5,7,1,3,6\n")  # through the inside
    assert read(tmp_path, faces + "PSHELL,7,1,.1\n", "CQUAD4").left_out[0].why == "left out by leave_out in [mesh]"
    with pytest.raises(InputError, match=r"names 'CQAUD4', and .* has no card of this name"):
        read(tmp_path, faces, "CQAUD4")


def test_sets_that_are_no_groups_are_told(tmp_path):
    found = read(tmp_path, CUBE + "SET,7,GRID,LIST\n+,1,2\n")
    assert [(each.what, each.number) for each in found.left_out] == [("SET", 1)]


def test_shells_alone_are_a_plane_body(tmp_path):
    found = read(tmp_path, PLATE + "CTRIA6,2,1,1,2,3,5,6,7\nPSHELL,1,1,.1\nCONM2,3,1,,5.\n")
    assert [(kind, nodes.tolist()) for kind, nodes in found.cells] == [
        ("quad", [[0, 1, 2, 3]]),
        ("triangle6", [[0, 1, 2, 4, 5, 6]]),
    ]
    assert len(found.masses) == 1


def test_what_is_no_part_of_the_body_is_told(tmp_path):
    more = "RBE2,50,1,123456,2,3\nSPC1,1,123456,1\nFORCE,1,2,0,1.,1.,0.,0.\nPLOTEL,60,1,2\nGRID,99,,0.,0.,0.,,123\nMAT1,1,1.,,.3,2.\n"
    materials = "MAT1,2,1.,,.3,3.\nPSOLID,1,1\nPSOLID,2,2\nCTETRA,70,2,1,2,3,5\n"
    found = read(tmp_path, CUBE + more + materials)
    assert [each.what for each in found.left_out] == ["RBE2", "SPC1", "FORCE", "PLOTEL", "GRID"]
    assert found.remarks == ["The elements of the file have 2 materials; those of the body have the one of body.toml."]


def test_what_follows_the_end_or_the_last_column_is_told(tmp_path):
    text = CUBE.replace("GRID,1,,0.,0.,0.", f"{'GRID           1':80}beyond") + "ENDDATA\nGRID,5,,1.,2.,3.\n"
    first, second = read(tmp_path, text).remarks
    assert first.startswith("1 lines have more than 80")
    assert second.startswith("What follows ENDDATA")


REFUSED = {
    "unknown": (CUBE + "MYCARD,1,2\n", r"line 11: this card is not known here, and may carry mass"),
    "element": (
        CUBE + "CELAS2,5,1.E6,1,1\nCONROD,6,1,2,1,.1\n",
        r'1 CELAS2, the first in .*line 11; 1 CONROD, .*"CELAS2", "CONROD"',
    ),
    "pyramid": (CUBE + "CPYRAM,5,1,1,2,3,4,5\n", r'1 CPYRAM, the first in .*leave_out = \["CPYRAM"\]'),
    "matrices": (CUBE + "DMIG,K2GG,0,6,1,0\nCMASS2,8,5.,1,1\nNSM,9,PSOLID,1,.1\n", "1 CMASS2, .*1 DMIG, .*1 NSM"),
    "no whole number": (CUBE.replace("1,2,3,4,5,6", "1,2,3.,4,5,6"), r"line 9: field 6 of CHEXA holds no whole number"),
    "no number": (CUBE.replace("GRID,2,,1.", "GRID,2,,1.5O"), r"line 2: field 4 of GRID holds no number"),
    "decimal comma": (CUBE.replace("GRID,2,,1.,0.,0.", "GRID,2,,1,5,0.,0."), r"holds no (whole )?number|line 2"),
    "a number too many": (
        CUBE.replace(",7,8", ",7,8," + "1," * 6 + "\n,1,1,1,1,1,1,1"),
        r"line 9: CHEXA has more fields than 22",
    ),
    "missing node": (CUBE.replace("GRID,3", "GRID,33"), r"line 9: CHEXA has node 3, and no GRID"),
    "some middles": (
        CUBE.replace(",7,8", ",7,8,1,2"),
        r"line 9: CHEXA is read with 8 or 20 nodes, .*Give it all middles, or none",
    ),
    "corner is blank": (CUBE.replace(",7,8", ",7"), r"line 9: CHEXA is read with 8 or 20 nodes"),
    "node twice": (CUBE + "GRID,3,,9.,1.,0.\n", r"line 11: GRID 3 is at another place than in .*line 3"),
    "element twice": (CUBE + "CTETRA,1,1,1,2,3,5\n", r"element 1 is there twice"),
    "no system": (CUBE.replace("GRID,3,,", "GRID,3,8,"), r"line 3: GRID lies in coordinate system 8"),
    "circle of systems": (
        CUBE.replace("GRID,3,,", "GRID,3,8,") + "CORD1R,8,1,2,3\n",
        r"coordinate systems 8, 8 rest on each other",
    ),
    "line of points": (CUBE.replace("GRID,3,,", "GRID,3,8,") + "CORD2R,8,,0.,0.,0.,1.,0.,0.\n,2.,0.,0.\n", r"lie on one line"),
    "system twice": (CUBE + "CORD1R,8,1,2,4\nCORD1R,8,1,2,5\n", r"line 12: coordinate system 8 is defined twice"),
    "fluid": (CUBE.replace("GRID,3,,1.,1.,0.", "GRID,3,,1.,1.,0.,-1"), r"line 3: GRID is a node of a fluid"),
    "fluid by its property": (CUBE + "PSOLID,1,1,,,,,PFLUID\n", r"line 11: PSOLID is that of a fluid"),
    "mass by direction": (CUBE + "CONM1,5,1,,1.,0.,2.\n", r"line 11: CONM1 has a mass that differs by direction"),
    "mass on air": (CUBE + "GRID,9\nCONM2,5,9,,1.\n", r"line 12: the mass is on node 9, .*0 rigid elements tie it"),
    "mass by weights": (
        CUBE + "GRID,9\nCONM2,5,9,,1.\nRBE3,7,,9,123,1.,123,1,2\n,3,2.,123,4\n",
        r"RBE3 ties it, but leaves translations free or weighs",
    ),
    "mass by a wrong tie": (
        CUBE + "GRID,9\nCONM2,5,9,,1.\nRBE3,7,,9,123,1,123,1,2\n",
        r"line 13: RBE3 is not read as it is written",
    ),
    "mass in a round system": (
        CUBE + "CORD1C,8,1,2,4\nCONM2,5,1,8,1.,.1\n",
        r"CONM2 has an offset or inertia in a cylindrical or spherical system",
    ),
    "negative mass": (CUBE + "CONM2,5,1,,-1.\n", r"line 11: CONM2 has a negative mass"),
    "nothing to continue": ("+,1,2\n" + CUBE, r"line 1: the line continues a card, and there is none"),
    "lost mark": (CUBE.replace("5,6\n,7,8", "5,6,+A\n+B,7,8"), r"line 10: the line continues a card, and none has its mark"),
    "copied fields": (CUBE + "=,*(1),=,*(1.)\n", r"line 11: a field is to be copied from the card before it"),
    "no card": (CUBE + "1234,5\n", r"line 11: the line begins with no name of a card"),
    "superelement": (CUBE + "BEGIN SUPER=2\n" + CUBE, r"line 11: BEGIN begins a superelement"),
    "no bulk": ("SOL 101\nCEND\n" + CUBE, r"line 2: CEND is not followed by BEGIN BULK"),
    "no text": ("\0", "holds zero bytes"),
    "two defaults": ("GRDSET,,0\nGRDSET,,0\n" + CUBE, "there are two GRDSET"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_what_cannot_be_part_of_a_body_is_refused_by_name_and_line(kind, tmp_path):
    text, message = REFUSED[kind]
    with pytest.raises(InputError, match=message):
        read(tmp_path, text)


@pytest.mark.parametrize("kind", ["unknown", "element", "matrices", "mass on air", "pyramid"])
def test_what_carries_mass_may_be_left_out_on_purpose(kind, tmp_path):
    text = REFUSED[kind][0]
    names = {
        each
        for each in ("MYCARD", "CELAS2", "CONROD", "DMIG", "CMASS2", "NSM", "CONM2", "CPYRAM")
        if any(line.startswith((each + ",", each + " ")) for line in text.splitlines())
    }
    found = read(tmp_path, text, *names)
    assert {each.what for each in found.left_out} == names
    assert names
    assert len(found.masses) == 0


NUMBERS = {
    "1.5-7": 1.5e-7, "1.5+7": 1.5e7, "1.D-7": 1e-7, ".5": 0.5, "-.5-3": -0.5e-3, "+2.": 2.0, "3": 3.0, "1.E5": 1e5, "7.0e+0": 7.0,
    "1E5": 1e5, "0.1234567890123456789": 0.1234567890123456789, "1.7976931348623157+308": 1.7976931348623157e308, "  2.5": 2.5, "": 0.0,
    "4.9-324": 4.9e-324, "123456789012345678901.": 123456789012345678901.0,
}  # fmt: skip
WRONG = [
    "1.5 -7",
    "1+5",
    ".",
    "+",
    "1.5-",
    "1.5E",
    "--1.",
    "1,5",
    "nan",
    "inf",
    "1_0",
    "0x1",
    "1.5-7-7",
    "1.+400",
    "٣",
    "2.0abc",
    "1.0 2.0",
]


@pytest.mark.parametrize("text", NUMBERS)
def test_numbers_are_the_nearest_to_what_is_written(text):
    found = real_numbers(np.frombuffer(text.ljust(40).encode(), np.uint8)[None])
    assert (found.values[0], found.wrong[0], found.blank[0]) == (NUMBERS[text], False, text == "")


@pytest.mark.parametrize("text", WRONG)
def test_other_text_is_no_number(text):
    letters = np.frombuffer(text.ljust(40).encode().ljust(44), np.uint8)[None]
    assert real_numbers(letters).wrong[0]
    assert whole_numbers(letters).wrong[0]


def test_many_numbers_at_once_are_those_of_python():
    rng = np.random.default_rng(4)
    texts = [f"{rng.uniform(-1, 1) * 10.0 ** rng.integers(-30, 30):.{rng.integers(1, 18)}e}" for _ in range(3000)]
    found = real_numbers(np.array(texts, "S32").view(np.uint8).reshape(3000, 32).clip(min=32))
    assert found.values.tolist() == list(map(float, texts))
    assert not found.wrong.any()


def test_included_files_are_found_from_the_main_file_or_beside_the_one_that_names_them(tmp_path):
    (tmp_path / "deep").mkdir()
    (tmp_path / "body.bdf").write_text("INCLUDE 'deep/\n    nodes.txt' $ over two lines\nCHEXA,1,1,1,2,3,4,5,6\n,7,8\n")
    (tmp_path / "deep" / "nodes.txt").write_text(GRID + 'include "more.txt"\n')
    (tmp_path / "deep" / "more.txt").write_text("GRID,9,,5.,5.,5.\n")
    found = read_bulk(tmp_path / "body.bdf", frozenset())
    assert len(found.points) == 9
    assert drawn_on(tmp_path / "body.bdf") == [tmp_path / "deep" / "nodes.txt", tmp_path / "deep" / "more.txt"]
    (tmp_path / "more.txt").write_text("GRID,9,,6.,5.,5.\n")
    for reading in (lambda path: read_bulk(path, frozenset()), drawn_on):
        with pytest.raises(InputError, match=r"that there is twice: .*more\.txt' and .*deep/more\.txt'"):
            reading(tmp_path / "body.bdf")


def test_a_place_in_an_included_file_is_named(tmp_path):
    (tmp_path / "more.blk").write_text("$ nothing\nGRID,1,,x\n")
    with pytest.raises(InputError, match=r"more\.blk', line 2: field 4 of GRID holds no number"):
        read(tmp_path, "INCLUDE more.blk\n" + CUBE)
    (tmp_path / "more.blk").write_text("")
    with pytest.raises(InputError, match=r"body\.bdf', line 2: field 4 of GRID holds no number"):
        read(tmp_path, "INCLUDE 'more.blk'\nGRID,1,,y\n")


@pytest.mark.parametrize("reading", [lambda path: read_bulk(path, frozenset()), drawn_on], ids=["reader", "names"])
def test_files_that_include_each_other_without_end_are_refused(reading, tmp_path):
    (tmp_path / "body.bdf").write_text("INCLUDE 'other.blk'\n")
    (tmp_path / "other.blk").write_text("INCLUDE 'body.bdf'\n")
    with pytest.raises(InputError, match=r"other\.blk' includes .*body\.bdf', which includes it in turn"):
        reading(tmp_path / "body.bdf")
    for k in range(30):
        (tmp_path / f"row{k}.blk").write_text(f"INCLUDE 'row{k + 1}.blk'\n" * 2)
    (tmp_path / "row30.blk").write_text(CUBE)
    with pytest.raises(InputError, match="includes more than 1000 files, or more than 20 in a row"):
        reading(tmp_path / "row0.blk")


def test_nodes_keep_their_numbers_and_sets_their_members(tmp_path):
    found = read(tmp_path, CUBE + "SET1,5,8,1,THRU,3\nSET3,6,ELEM,1\nSET3,7,PROP,1\nSET1,9,1,77\n")
    groups = {
        name: sorted({int(k) for _, nodes in elements for k in found.labels[nodes].ravel()}) for name, elements in found.groups
    }
    assert groups == {"pid 1": [*range(1, 9)], "SET1 5": [1, 2, 3, 8], "SET3 6": [*range(1, 9)]}
    assert [(each.what, each.number) for each in found.left_out] == [("SET1", 1), ("SET3", 1)]


@pytest.mark.parametrize("kind", ["tetra", "hexahedron", "wedge"])
def test_a_mesh_that_meshio_writes_comes_back(kind, tmp_path):
    """It writes elements of second order under names that no Nastran has, such as CTETRA_, which are refused."""
    solid = box(kind, (2, 1, 1), (1.0, 0.5, 0.25))
    meshio.write(tmp_path / "body.bdf", meshio.Mesh(solid.nodes, [(kind, solid.blocks[kind])]))
    found = read_bulk(tmp_path / "body.bdf", frozenset())
    np.testing.assert_allclose(found.points, solid.nodes, atol=1e-9)
    ((name, nodes),) = found.cells
    assert name == kind
    np.testing.assert_array_equal(nodes, solid.blocks[kind])


def test_no_card_has_two_meanings():
    tables = [TAKEN, CARRYING, set(WHY), OTHERS]
    assert sum(map(len, tables)) == len(set().union(*tables))
