"""The reader of gmsh's .msh on small files: what stands in them is read, and what contradicts itself is refused with its line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from preprocessing.foreign_files.contents import MeshContents
from preprocessing.foreign_files.gmsh_mesh import gmsh_mesh
from preprocessing.mesh.mesh_file import read_mesh
from toolkit.foundation.errors import InputError

HEAD = "$MeshFormat\n{} 0 8\n$EndMeshFormat\n"
NODES = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n"
SQUARE = HEAD.format("2.2") + NODES + "$Elements\n{n}\n{rows}\n$EndElements\n"
NODES_4 = "$Nodes\n1 4 1 4\n2 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n$EndNodes\n"
SQUARE_4 = HEAD.format("4.1") + "{entities}" + NODES_4 + "$Elements\n{elements}\n$EndElements\n"
ENTITIES = "$Entities\n0 2 1 0\n1 0 0 0 1 0 0 1 -7 0\n2 0 0 0 0 1 0 1 7 0\n1 0 0 0 1 1 0 2 5 -9 0\n$EndEntities\n"
ELEMENTS = "3 4 1 4\n1 1 1 1\n1 1 2\n1 2 1 1\n2 4 1\n2 1 2 2\n3 1 2 3\n4 1 3 4"


def read(folder: Path, text: str | bytes, leave_out: frozenset[str] = frozenset()) -> MeshContents:
    path = folder / "body.msh"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return gmsh_mesh(path, leave_out)


def square(*rows: str) -> str:
    return SQUARE.format(n=len(rows), rows="\n".join(rows))


def named(*lines: str) -> str:
    return f"$PhysicalNames\n{len(lines)}\n" + "".join(line + "\n" for line in lines) + "$EndPhysicalNames\n"


def groups(found: MeshContents) -> dict[str, list[list[int]]]:
    """Nodes of the elements of each group."""
    return {name: [row for _, nodes in elements for row in nodes.tolist()] for name, elements in found.groups}


def test_groups_are_those_of_both_signs_and_of_every_entity(tmp_path):
    found = read(tmp_path, SQUARE_4.format(entities=ENTITIES, elements=ELEMENTS))
    assert groups(found) == {
        "physical curve 7": [[0, 1], [3, 0]],
        "physical surface 5": [[0, 1, 2], [0, 2, 3]],
        "physical surface 9": [[0, 1, 2], [0, 2, 3]],
    }


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_names_keep_their_blanks_quotation_marks_and_letters(tmp_path, ends):
    names = named('1 7 "left "old" ünd"', '2 5 " plate "', '2 9 ""')
    text = SQUARE_4.format(entities=names + ENTITIES, elements=ELEMENTS).replace("\n", ends)
    assert list(groups(read(tmp_path, text))) == ['left "old" ünd', " plate ", ""]


def test_a_name_of_several_groups_of_one_dimension_is_that_of_all_together(tmp_path):
    text = square("1 2 2 1 1 1 2 3", "2 2 2 2 1 1 2 3", "3 2 2 2 1 1 3 4")
    found = read(tmp_path, text + named('2 1 "plate"', '2 2 "plate"'))
    assert groups(found) == {"plate": [[0, 1, 2], [0, 2, 3]]}
    assert found.remarks == ["The group 'plate' is made of 2 physical groups of this name."]


def test_an_element_in_several_groups_stands_once(tmp_path):
    """MSH 2.2 writes it once for each of its groups, the other way round in a group against the direction of its entity."""
    found = read(tmp_path, square("1 2 2 1 1 1 2 3", "2 2 2 2 1 1 3 2", "3 2 2 1 1 1 3 4", "4 1 2 8 3 1 2", "5 1 2 9 3 2 1"))
    assert [(kind, len(nodes)) for kind, nodes in found.cells] == [("triangle", 2), ("line", 1)]
    assert groups(found) == {
        "physical surface 1": [[0, 1, 2], [0, 2, 3]],
        "physical surface 2": [[0, 1, 2]],
        "physical curve 8": [[0, 1]],
        "physical curve 9": [[0, 1]],
    }


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize(
    "again", ["2 2 2 1 1 1 2 3", "2 2 2 0 1 1 2 3", "2 2 2 2 2 1 2 3"], ids=["same group", "no group", "another entity"]
)
def test_an_element_that_is_there_twice_otherwise_is_refused(tmp_path, again):
    (tmp_path / "body.msh").write_text(square("1 2 2 1 1 1 2 3", again, "3 2 2 1 1 1 3 4"))
    with pytest.raises(InputError, match="holds 1 elements twice"):
        read_mesh(tmp_path / "body.msh")


@pytest.mark.usefixtures("read_here")
def test_an_element_twice_in_version_4_is_refused(tmp_path):
    elements = ELEMENTS.replace("3 4 1 4", "4 5 1 5") + "\n2 1 2 1\n5 3 2 1"
    (tmp_path / "body.msh").write_text(SQUARE_4.format(entities=ENTITIES, elements=elements))
    with pytest.raises(InputError, match="holds 1 elements twice"):
        read_mesh(tmp_path / "body.msh")


def test_numbers_of_nodes_may_be_as_large_as_they_like(tmp_path):
    found = read(
        tmp_path,
        square("1 2 2 1 1 1 2 4000000000000000", "2 2 2 1 1 1 4000000000000000 4").replace("\n3 1", "\n4000000000000000 1"),
    )
    assert found.labels.tolist() == [1, 2, 4 * 10**15, 4]
    assert [nodes.tolist() for _, nodes in found.cells] == [[[0, 1, 2], [0, 2, 3]]]


def test_sections_that_are_not_known_are_told(tmp_path):
    found = read(tmp_path, square("1 2 2 1 1 1 2 3") + "$Comments\n$Nodes\n$EndComments\n$Strange\n1\n$EndStrange\n")
    assert found.remarks == ["Sections that gmsh does not know were skipped: 1, the first in line 19."]


def test_named_groups_without_elements_are_told(tmp_path):
    text = square("1 2 2 0 1 1 2 3").replace("$Nodes", named('2 1 "plate"') + "$Nodes", 1)
    (remark,) = read(tmp_path, text).remarks
    assert remark.startswith("1 of 1 named groups have no elements")


ROW = "1 2 2 1 1 1 2 3"
WRONG = {
    "a word for a number": (square("1 2 2 1 1 1 2 x"), "line 13: a word is no number"),
    "a comma for a point": (square(ROW).replace("2 1 0 0", "2 1,5 0 0"), "line 7: a word is no number"),
    "letters behind a number": (square(ROW).replace("2 1 0 0", "2 1.0abc 0 0"), "line 7: a word is no number"),
    "half a tag": (square("1 2 2 1 1 1 2.5 3"), "other numbers than whole ones"),
    "a row that is short": (square("1 2 2 1 1 1 2"), "a row of .Elements has not as many numbers"),
    "a row too many": (square(ROW, ROW).replace("\n2\n", "\n1\n"), ".Elements has not as many elements as it says"),
    "a type that is none": (square("1 777 2 1 1 1 2 3"), "elements besides points, lines, triangles"),
    "a node that is not there": (square("1 2 2 1 1 1 2 9"), "a node that the file does not hold"),
    "a node twice": (square(ROW).replace("\n2 1 0 0", "\n1 1 0 0"), "one number to two nodes"),
    "more tags than numbers": (square("1 2 999999999 1 1 1 2 3"), "a row of .Elements"),
    "too many nodes": (square(ROW).replace("$Nodes\n4\n", "$Nodes\n999999999999\n"), "line 5: .Nodes claims more numbers"),
    "fewer nodes": (square(ROW).replace("$Nodes\n4\n", "$Nodes\n3\n"), ".Nodes holds more numbers than it says"),
    "no nodes": (HEAD.format("2.2") + "$Elements\n1\n1 15 2 1 1 1\n$EndElements\n", "no section .Nodes"),
    "nodes twice": (square(ROW) + NODES, "a section stands there twice"),
    "no end": (square(ROW)[:-14], "line 11: a section has no end"),
    "a line outside": (square(ROW).replace("$Elements", "stray\n$Elements"), "line 11: a line stands outside"),
    "no name in quotation marks": (square(ROW) + named("2 1 plate"), "line 17: a line of .PhysicalNames"),
    "fewer names": (square(ROW) + named('2 1 "a"').replace("\n1\n", "\n2\n"), "not as many lines as it says"),
    "another version": (square(ROW).replace("2.2 0", "4.0 0"), r"another version than 1, 2 or 4\.1"),
    "no format": (NODES, "does not begin with .MeshFormat"),
    "Fluent": ("(0 grid)", "a mesh of Ansys Fluent"),
    "entities that end": (
        SQUARE_4.format(entities=ENTITIES.replace("0 2 1 0", "0 2 9999999 0"), elements=ELEMENTS),
        ".Entities claims more numbers",
    ),
    "a list that is longer": (
        SQUARE_4.format(entities=ENTITIES.replace("1 -7 0", "9999999999 -7 0"), elements=ELEMENTS),
        ".Entities claims more numbers",
    ),
    "elements on a point": (
        SQUARE_4.format(entities="", elements="1 1 1 1\n0 1 2 1\n3 1 2 3"),
        "elements on an entity of another dimension",
    ),
    "fewer elements": (SQUARE_4.format(entities="", elements="1 7 1 7\n2 1 2 1\n3 1 2 3"), "not as many elements as it says"),
}  # fmt: skip


@pytest.mark.parametrize("kind", WRONG)
def test_what_contradicts_itself_is_refused_where_it_stands(tmp_path, kind):
    text, message = WRONG[kind]
    with pytest.raises(InputError, match=rf"body\.msh' cannot be read \(.*{message}"):
        read(tmp_path, text)


def test_nothing_of_a_mesh_of_gmsh_can_be_left_out(tmp_path):
    with pytest.raises(InputError, match=r"leave_out in \[mesh\] names S4R, but"):
        read(tmp_path, square(ROW), frozenset({"S4R"}))


def binary_2(order: str) -> bytes:
    """The square in binary MSH 2.2 with one order of bytes."""
    whole, real = np.dtype(f"{order}i4"), np.dtype(f"{order}f8")
    places = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    nodes = b"".join(np.array(k + 1, whole).tobytes() + np.array(place, real).tobytes() for k, place in enumerate(places))
    triangles = np.array([2, 2, 2, 1, 5, 1, 1, 2, 3, 2, 5, 1, 1, 3, 4], whole).tobytes()
    line = np.array([1, 1, 2, 3, -7, 4, 1, 2], whole).tobytes()
    one = np.array(1, whole).tobytes()
    return (b"$MeshFormat\n2.2 1 8\n" + one + b"\n$EndMeshFormat\n$Nodes\n4\n" + nodes + b"\n$EndNodes\n$Elements\n3\n"
            + triangles + line + b"\n$EndElements\n")  # fmt: skip


@pytest.mark.parametrize("order", "<>")
def test_both_orders_of_bytes_are_read(tmp_path, order):
    found = read(tmp_path, binary_2(order))
    assert groups(found) == {"physical surface 5": [[0, 1, 2], [0, 2, 3]], "physical curve 7": [[0, 1]]}
    np.testing.assert_array_equal(found.points[2], [1, 1, 0])


@pytest.mark.parametrize("length", [40, 60, 100, 190, 230, 260])
def test_a_binary_file_that_ends_is_refused(tmp_path, length):
    whole = binary_2("<")
    assert length < len(whole)
    with pytest.raises(InputError, match=r"body\.msh' cannot be read"):
        read(tmp_path, whole[:length])


def test_a_binary_file_never_takes_more_memory_than_it_has_bytes(tmp_path):
    """A block that claims two thousand million elements."""
    claimed = binary_2("<").replace(np.array([2, 2, 2], "<i4").tobytes(), np.array([2, 2**31 - 1, 2], "<i4").tobytes())
    with pytest.raises(InputError, match=r"\$Elements claims more numbers"):
        read(tmp_path, claimed)
