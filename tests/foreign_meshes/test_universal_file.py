"""The reader of universal files (UNV) on small files; those of gmsh are in `test_meshes_of_gmsh`."""

from __future__ import annotations

from pathlib import Path

import pytest

from preprocessing.foreign_files.contents import MeshContents
from preprocessing.foreign_files.universal_file import universal_mesh
from toolkit.foundation.errors import InputError


def dataset(number: int | str, *rows: str) -> str:
    return "\n".join(["    -1", f"{number:>6}", *rows, "    -1"]) + "\n"


def integers(*numbers: int) -> str:
    return "".join(f"{number:10d}" for number in numbers)


PLACES = {11: (0, 0), 12: (1, 0), 13: (1, 1), 24: (0, 1)}
ROWS = [row for label, (x, y) in PLACES.items() for row in (integers(label, 1, 1, 11), f"   {x}.0D+00   {y}.0D+00   0.0D+00")]
NODES = dataset(2411, *ROWS)
ELEMENTS = (
    integers(1, 44, 2, 1, 7, 4),
    integers(11, 12, 13, 24),
    integers(7, 21, 1, 1, 7, 2),
    integers(0, 0, 0),
    integers(24, 11),
)
MASS = (integers(9, 136, 1, 1, 7, 1), integers(13))
GROUPS = dataset(2467, integers(1, 0, 0, 0, 0, 0, 0, 3), "held", integers(8, 7, 0, 0, 7, 13, 0, 0), integers(8, 99, 0, 0))
IDENTITY = ("1.0D+00 0.0D+00 0.0D+00", "0.0D+00 1.0D+00 0.0D+00", "0.0D+00 0.0D+00 1.0D+00", "0.0D+00 0.0D+00 0.0D+00")


def system(kind: int, *rows: str) -> str:
    return dataset(2420, integers(1), "part", integers(1, kind, 11), "Global", *rows)


def read(folder: Path, text: str, leave_out: frozenset[str] = frozenset()) -> MeshContents:
    (folder / "body.unv").write_text(text)
    return universal_mesh(folder / "body.unv", leave_out)


def test_nodes_elements_and_groups_of_both_are_read(tmp_path):
    units = dataset(164, "         5mm (milli-newton)         2", "  1.0D+03  1.0D+03  1.0D+00  2.7D+02")
    found = read(tmp_path, units + system(0, *IDENTITY) + NODES + dataset(2412, *ELEMENTS) + GROUPS + dataset(2414, "1"))
    assert found.labels.tolist() == [11, 12, 13, 24]
    assert [(kind, nodes.tolist()) for kind, nodes in found.cells] == [("quad", [[0, 1, 2, 3]]), ("line", [[3, 0]])]
    ((name, members),) = found.groups
    assert (name, [(kind, nodes.tolist()) for kind, nodes in members]) == ("held", [("vertex", [[2]]), ("line", [[3, 0]])])
    assert found.remarks == [
        "The file gives lengths in mm (millinewton), by its dataset 164.",
        "The group 'held' names 1 things besides nodes and elements of the file.",
        "Datasets that are no part of the mesh were not read: 2414.",
    ]


def test_masses_are_refused_by_name_or_left_out_on_purpose(tmp_path):
    text = NODES + dataset(2412, *ELEMENTS, *MASS)
    with pytest.raises(InputError, match=r'1 elements of descriptor 136 \(lumped mass\).*leave_out = \["136"\]'):
        read(tmp_path, text)
    (left,) = read(tmp_path, text, frozenset({"136"})).left_out
    assert (left.what, left.number) == ("descriptor 136", 1)
    with pytest.raises(InputError, match=r"names 999, and .* has no elements of such a descriptor"):
        read(tmp_path, text, frozenset({"136", "999"}))


WRONG = {
    "nothing": (dataset(2411)[:14], "its lines of -1 do not enclose datasets"),
    "no nodes": (dataset(2412, *ELEMENTS), "no dataset 2411 of nodes"),
    "old nodes": (dataset(15, "1"), "its nodes are in dataset 15, which is not read"),
    "a binary dataset": (dataset("58b", "1"), "line 2: a dataset has no number of text"),
    "a number missing": (dataset(2411, *ROWS[:-1]), "not seven numbers for each node"),
    "a word": (NODES.replace("1.0D+00", "1.0X+00", 1), "line 6: a word is no number"),
    "a node that is not there": (NODES + dataset(2412, ELEMENTS[0], integers(11, 12, 13, 25)), "a node that the file does not hold"),
    "more nodes than there are": (
        NODES + dataset(2412, integers(1, 44, 2, 1, 7, 999999999), ELEMENTS[1]),
        "not as many numbers as it says",
    ),
    "a number of two elements": (NODES + dataset(2412, *ELEMENTS, *ELEMENTS), "one number to two elements"),
    "a quadrilateral of three": (NODES + dataset(2412, integers(1, 44, 2, 1, 7, 3), integers(11, 12, 13)), "has not its 4 nodes"),
    "a cylindrical system": (system(1, *IDENTITY) + NODES, "coordinate system that is not the global Cartesian one"),
    "a moved system": (system(0, *IDENTITY[:3], "5.0D+00 0.0D+00 0.0D+00") + NODES, "not the global Cartesian one"),
    "a group of two names": (NODES + dataset(2412, *ELEMENTS) + GROUPS + GROUPS, "two groups have one name"),
    "a group that is short": (
        NODES + dataset(2412, *ELEMENTS) + GROUPS.replace(integers(0, 3), integers(0, 9)),
        "not as many members as it says",
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_not_read_is_refused(tmp_path, kind):
    text, message = WRONG[kind]
    with pytest.raises(InputError, match=message):
        read(tmp_path, text)
