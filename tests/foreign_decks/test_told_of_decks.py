"""What a deck says that is no part of the body, or cannot be read as a group, is told in words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from preprocessing.foreign_files.abaqus.reader import read_deck
from preprocessing.foreign_files.contents import MeshContents
from toolkit.foundation.errors import InputError

NODES = "1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n5, 0., 0., 1.\n6, 1., 0., 1.\n7, 1., 1., 1.\n8, 0., 1., 1.\n"
CUBE = f"*NODE\n{NODES}*ELEMENT, TYPE=C3D8, ELSET=cube\n1, 1, 2, 3, 4, 5, 6, 7, 8\n"
SHELL = "*ELEMENT, TYPE=S4, ELSET=bottom\n2, 1, 2, 3, 4\n"
PART = f"*PART, NAME=p\n{CUBE}*NSET, NSET=tip\n1\n*END PART\n"


def read(folder: Path, text: str, *leave_out: str) -> MeshContents:
    """What a deck of this text holds."""
    (folder / "body.inp").write_text(text)
    return read_deck(folder / "body.inp", frozenset(leave_out))


def nodes_of(contents: MeshContents, name: str) -> list[int]:
    """Numbers of the nodes of the only group of a name."""
    (elements,) = (own for each, own in contents.groups if each == name)
    return np.unique(np.concatenate([contents.labels[block].ravel() for _, block in elements])).tolist()


@pytest.mark.parametrize(("side", "nodes"), [("SPOS", [1, 2, 3, 4]), ("SNEG", [1, 2, 3, 4]), ("E1", [1, 2]), ("e4", [1, 4])])
def test_a_surface_of_shells_has_their_nodes_or_those_of_an_edge(side, nodes, tmp_path):
    assert nodes_of(read(tmp_path, f"{CUBE}{SHELL}*SURFACE, NAME=s\nbottom, {side}\n"), "s") == nodes


@pytest.mark.parametrize("line", ["cube, S7", "cube, SPOS", "cube", "cube, E1", "cube, S²", "bottom, END1", "1, THRU"])
def test_a_surface_of_sides_that_are_not_read_is_no_group_and_told(line, tmp_path):
    found = read(tmp_path, f"{CUBE}{SHELL}*SURFACE, NAME=s\n1, S1\n{line}\n")
    assert "s" not in [name for name, _ in found.groups]
    assert any("line 16" in remark and "is no group" in remark for remark in found.remarks)


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("NSET, NSET", "name 2 nodes that it does not have, the first of them 77"),
        ("ELSET, ELSET", "name 2 elements that it does not"),
    ],
)
def test_members_of_sets_that_there_are_not_are_told(kind, words, tmp_path):
    found = read(tmp_path, f"{CUBE}*{kind}=a\n1, 77, 78\n")
    assert any(words in remark for remark in found.remarks)


def test_numbers_of_a_range_that_nobody_has_are_no_news(tmp_path):
    found = read(tmp_path, f"{CUBE}*NSET, NSET=a, GENERATE\n1, 100\n")
    assert nodes_of(found, "a") == [1, 2, 3, 4, 5, 6, 7, 8]
    assert found.remarks == []


def test_a_set_of_the_assembly_does_not_hide_that_of_its_only_instance(tmp_path):
    assembly = "*ASSEMBLY, NAME=a\n*INSTANCE, NAME=p-1, PART=p\n*END INSTANCE\n*NSET, NSET=tip, INSTANCE=p-1\n7\n*END ASSEMBLY\n"
    found = read(tmp_path, PART + assembly)
    assert nodes_of(found, "tip") == [7]
    assert nodes_of(found, "p-1.tip") == [1]


def test_a_rigid_body_of_a_part_ties_the_set_of_its_part(tmp_path):
    """A node set and an element set, one of the assembly and one of the part, have the same name."""
    mass = "*ELEMENT, TYPE=MASS, ELSET=m\n9, 900\n*MASS, ELSET=m\n5.\n*NODE\n900, 2., 0., 0.\n"
    body = f"{CUBE}{mass}*RIGID BODY, REF NODE=900, ELSET=same\n"
    sets = "*ELSET, ELSET=same\n1\n*NSET, NSET=same\n2\n"
    assembly = "*ASSEMBLY, NAME=a\n*INSTANCE, NAME=p-1, PART=p\n*END INSTANCE\n*NSET, NSET=same, INSTANCE=p-1\n7\n*END ASSEMBLY\n"
    (found,) = read(tmp_path, f"*PART, NAME=p\n{sets}{body}*END PART\n{assembly}").masses
    assert len(found.carriers) == 8


def test_shells_that_are_left_out_leave_an_empty_set_that_others_may_name(tmp_path):
    text = f"{CUBE}{SHELL}*SHELL SECTION, ELSET=bottom\n0.1\n*ELSET, ELSET=all\ncube, bottom\n"
    found = read(tmp_path, text, "S4")
    assert nodes_of(found, "all") == [1, 2, 3, 4, 5, 6, 7, 8]
    assert [(each.what, each.number) for each in found.left_out] == [("S4", 1)]
    assert found.remarks == []


@pytest.mark.parametrize("start", [b"\xef\xbb\xbf", b"\xef\xbb\xbf\r\n", b"** comment\n"])
def test_a_byte_order_mark_or_comment_ahead_of_the_first_keyword_is_nothing(start, tmp_path):
    (tmp_path / "body.inp").write_bytes(start + CUBE.encode())
    found = read_deck(tmp_path / "body.inp", frozenset())
    assert len(found.points) == 8
    assert found.remarks == []


@pytest.mark.parametrize("keyword", ["ADJUST, SURFACE=a, NODE SET=b", "MASS ADJUST"])
def test_keywords_that_move_nodes_or_change_masses_are_refused(keyword, tmp_path):
    with pytest.raises(InputError, match=f"line 12: .{keyword.partition(',')[0]} stands for"):
        read(tmp_path, f"{CUBE}*{keyword}\n")


def test_a_file_in_utf_16_or_with_zero_bytes_is_no_deck(tmp_path):
    path = tmp_path / "body.inp"
    path.write_bytes(CUBE.encode("utf-16"))
    with pytest.raises(InputError, match="UTF-16"):
        read_deck(path, frozenset())
    path.write_bytes(CUBE.encode() + b"\0")
    with pytest.raises(InputError, match="zero bytes"):
        read_deck(path, frozenset())
