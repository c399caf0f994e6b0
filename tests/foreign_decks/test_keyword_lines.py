"""Keyword lines of decks with a comma too many or short and unknown parameters, and masses on reference nodes."""

from pathlib import Path

import numpy as np
import pytest

from preprocessing.foreign_files.abaqus import reader
from preprocessing.foreign_files.abaqus.generated import numbers_of
from preprocessing.foreign_files.abaqus.reader import read_deck
from preprocessing.foreign_files.contents import MeshContents
from toolkit.foundation.errors import InputError

BAR = Path("tests/data/bar_of_four_hexahedra.inp").read_text(encoding="ascii")


def read(path: Path, text: str) -> MeshContents:
    """The contents of a deck."""
    path.write_text(text, encoding="ascii")
    return read_deck(path, frozenset())


def nodes_of(found: MeshContents, name: str) -> list[int]:
    """Numbers in the deck of the nodes of a group."""
    elements = next(elements for each, elements in found.groups if each == name)
    return sorted(found.labels[np.unique(np.concatenate([nodes.ravel() for _, nodes in elements]))].tolist())


def test_a_comma_too_many_takes_no_data_line(tmp_path):
    """CalculiX 2.20 gives both decks 42.0367 Hz, clamped at three nodes and one more."""
    found = read(tmp_path / "a.inp", BAR.replace("ELSET=bar\n", "ELSET=bar,\n") + "*NSET, NSET=q, GENERATE,\n1, 3\n5, 5\n")
    assert [(kind, len(nodes)) for kind, nodes in found.cells] == [("hexahedron", 4)]
    assert nodes_of(found, "q") == [1, 2, 3, 5]


def test_an_instance_is_where_its_line_behind_a_comma_says(tmp_path):
    deck = (
        f"*PART, NAME=P\n{BAR}*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P,\n-10., 5.\n*END INSTANCE\n*END ASSEMBLY\n"
    )
    found = read(tmp_path / "a.inp", deck)
    assert found.points.min(axis=0).tolist() == [-10.0, 5.0, 0.0]


@pytest.mark.parametrize(
    "line", ["*NSET, NSET=q,\nleft, right\n", "*SURFACE, NAME=s,\nbar, S1\n", "*NODE, SOMETHING\n99, 1., 2., 3.\n"]
)
def test_a_parameter_without_a_value_that_is_not_known_is_refused(tmp_path, line):
    number = BAR.count("\n") + 1
    with pytest.raises(InputError, match=rf"line {number}: \*[A-Z]+ has a parameter that is not known"):
        read(tmp_path / "a.inp", BAR + line)


def test_a_parameter_with_a_value_that_is_not_known_is_told(tmp_path):
    found = read(tmp_path / "a.inp", BAR + "*NSET, NSET=q, FREQUENCY=100\n1, 2\n")
    assert nodes_of(found, "q") == [1, 2]
    assert any("*NSET has a parameter that is not known" in each for each in found.remarks)


def test_the_first_letters_of_a_parameter_are_enough(tmp_path):
    """As the input syntax of Abaqus says: "not spelled out completely", where they are those of one parameter only."""
    found = read(tmp_path / "a.inp", BAR.replace("*NODE\n", "*NODE, SYS=C\n") + "*NSET, NSET=q, GEN\n1, 5\n")
    assert nodes_of(found, "q") == [1, 2, 3, 4, 5]
    place = found.points[found.labels == 10][0]
    assert place == pytest.approx([4 * np.cos(np.radians(1)), 4 * np.sin(np.radians(1)), 0.0])


MASS = """*NODE
100, 5., .5, .25
*ELEMENT, TYPE=MASS, ELSET=m
50, 100
*MASS, ELSET=m
250.
*SURFACE, NAME=s, TYPE=NODE
right
*SURFACE, NAME=t, TYPE=NODE
left
"""


def coupling(surface: str, how: str, line: str = "") -> str:
    """A coupling to the node of the mass."""
    return f"*COUPLING, CONSTRAINT NAME=c, REF NODE=100, SURFACE={surface}\n*{how}\n{line}"


@pytest.mark.parametrize(
    ("ties", "carriers"),
    [
        (coupling("s", "KINEMATIC", "1, 3\n"), [5, 10, 15, 20]),
        (coupling("s", "KINEMATIC", "1\n2\n3\n"), [5, 10, 15, 20]),
        (coupling("s", "KINEMATIC") + coupling("t", "KINEMATIC"), [1, 5, 6, 10, 11, 15, 16, 20]),
        ("*KINEMATIC COUPLING, REF NODE=100\nright, 1, 6\n", [5, 10, 15, 20]),
    ],
)
def test_a_mass_moves_with_all_nodes_that_are_tied_to_its_node(tmp_path, ties, carriers):
    found = read(tmp_path / "a.inp", BAR + MASS + ties)
    assert sorted(found.labels[found.masses[0].carriers].tolist()) == carriers


@pytest.mark.parametrize(
    "ties",
    [
        coupling("s", "KINEMATIC", "1, 1\n"),
        coupling("s", "KINEMATIC") + coupling("t", "DISTRIBUTING"),
        "*KINEMATIC COUPLING, REF NODE=100\nright, 1, 2\n",
        "*RIGID BODY, REF NODE=100, TIE NSET=right, POSITION=CENTER OF MASS\n",
    ],
)
def test_a_mass_on_a_node_that_is_not_tied_as_a_whole_is_refused(tmp_path, ties):
    with pytest.raises(
        InputError, match=r"line \d+: a concentrated mass is on the reference node of \*(COUPLING|KINEMATIC|RIGID)"
    ):
        read(tmp_path / "a.inp", BAR + MASS + ties)


def test_nodes_of_an_assembly_count_behind_those_of_its_instances(tmp_path):
    """Numbers of nodes in body.toml are those in the order of the file."""
    deck = f"*PART, NAME=P\n{BAR}*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n*NODE, NSET=RP\n1, 9., 9., 9.\n"
    found = read(tmp_path / "a.inp", deck + "*NSET, NSET=end, INSTANCE=I\n5, 20\n*END ASSEMBLY\n")
    assert found.points[4].tolist() == [4.0, 0.0, 0.0]
    assert found.points[20].tolist() == [9.0, 9.0, 9.0]
    places = {name: nodes[0][1].ravel().tolist() for name, nodes in found.groups}
    assert (places["RP"], places["end"], places["right"]) == ([20], [4, 19], [4, 14, 9, 19])


def test_each_of_many_masses_has_its_own_value(tmp_path, monkeypatch):
    """The sets of the blocks *MASS are looked at once each: looking at all of them for every element took minutes for a thousand."""
    asked = list[str]()
    monkeypatch.setattr(reader, "numbers_of", lambda *words: asked.append("") or numbers_of(*words))
    blocks = "".join(
        f"*ELEMENT, TYPE=MASS, ELSET=m{k}\n{50 + k}, {k % 20 + 1}\n*MASS, ELSET=m{k}\n{k + 1}.\n" for k in range(300)
    )
    found = read(tmp_path / "a.inp", BAR + blocks + "*MASS, ELSET=m7\n1000.\n")
    assert [each.mass for each in found.masses] == [k + 1 if k != 7 else 1000 for k in range(300)]
    assert [int(found.labels[each.carriers[0]]) for each in found.masses] == [k % 20 + 1 for k in range(300)]
    assert len(asked) == 301
