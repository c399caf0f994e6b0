"""Universal files (UNV) of I-DEAS, which Salome, gmsh and others write: datasets between lines of -1, each behind its number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.child import LARGEST_FILE
from preprocessing.foreign_files.contents import (
    Elements,
    Labels,
    LeftOutContent,
    MeshContents,
    alike_rows,
    numbers_of_text,
    whole_numbers,
    wrong_file,
)
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import read_whole

KINDS = {
    **dict.fromkeys((11, 21, 22, 31), "line"),
    **dict.fromkeys((23, 24), "line3"),
    **dict.fromkeys((41, 51, 61, 74, 81, 91), "triangle"),
    **dict.fromkeys((42, 52, 62, 72, 82, 92), "triangle6"),
    **dict.fromkeys((44, 54, 64, 71, 84, 94), "quad"),
    **dict.fromkeys((45, 55, 65, 75, 85, 95), "quad8"),
    **{111: "tetra", 118: "tetra10", 112: "wedge", 113: "wedge15", 115: "hexahedron", 116: "hexahedron20"},
}
"""Descriptor of an element -> its kind in the words of meshio."""
BEAMS = (21, 22, 23, 24)
"""Descriptors of elements that have a row more, of their orientation and sections."""
NODES = {
    "line": 2, "line3": 3, "triangle": 3, "triangle6": 6, "quad": 4, "quad8": 8, "tetra": 4, "tetra10": 10, "wedge": 6, "wedge15": 15,
    "hexahedron": 8, "hexahedron20": 20,
}  # fmt: skip
"""Kind -> its number of nodes."""
ORDERS = {
    "line3": [0, 2, 1],
    "triangle6": [0, 2, 4, 1, 3, 5],
    "quad8": [0, 2, 4, 6, 1, 3, 5, 7],
    "tetra10": [0, 2, 4, 9, 1, 3, 5, 6, 7, 8],
    "wedge15": [0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8],
    "hexahedron20": [0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11],
}
"""Kind -> place of every node in a universal file, which goes round each face, corner by middle."""
OTHERS = {
    32: "curved pipe", 121: "rigid bar", 122: "rigid element", 136: "lumped mass", 137: "axisymmetric lumped mass",
    138: "constraint element", 139: "plastic spring", 141: "node to ground translational spring",
    142: "node to ground rotational spring", 151: "node to node translational spring", 152: "node to node rotational spring",
    161: "node to node damper", 171: "gap", 43: "plane stress cubic triangle", 46: "plane stress cubic quadrilateral",
    93: "thin shell cubic triangle", 96: "thin shell cubic quadrilateral", 101: "thick shell linear wedge",
    102: "thick shell parabolic wedge", 104: "thick shell linear brick", 105: "thick shell parabolic brick", 114: "solid cubic wedge",
    117: "solid cubic brick",
}  # fmt: skip
"""Descriptors of elements that are none of the body's, and what they are."""
UNITS = {
    1: "m (SI)", 2: "foot (pound)", 3: "m (kilogram-force)", 4: "foot (poundal)", 5: "mm (millinewton)", 6: "cm (centinewton)",
    7: "inch (pound)", 8: "mm (kilogram-force)", 9: "a unit of the user", 10: "mm (newton)",
}  # fmt: skip
"""Code of dataset 164 -> the length that it stands for."""


REMEDY = "Export it again as a universal file with the datasets 2411, 2412 and 2467, or as gmsh .msh."
NODE_SETS, ELEMENT_SETS, GROUP_SETS = (2411, 781), (2412,), (2467, 2477, 2452, 2435)
REFUSED = {
    15: "nodes",
    71: "elements",
    780: "elements",
    18: "coordinate systems",
    2417: "groups",
    2429: "groups",
    2430: "groups",
    2432: "groups",
}
"""Datasets of older forms, and what they hold."""
NODE, ELEMENT = 7, 8
"""Codes of what a group consists of."""


class Dataset(NamedTuple):
    """Dataset of a universal file, between two lines of -1."""

    number: int
    line: int  # of its first line behind the number
    rows: list[bytes]

    @property
    def numbers(self) -> bytes:
        """Text of the dataset with exponents as C writes them."""
        return b"\n".join(self.rows).replace(b"D", b"E").replace(b"d", b"e")


class UniversalElement(NamedTuple):
    """Elements of one kind."""

    descriptor: int
    labels: np.ndarray  # (n_e,)
    nodes: np.ndarray  # (n_e, n_local), labels of nodes in the order of the file


def universal_mesh(path: Path, leave_out: frozenset[str]) -> MeshContents:
    """Nodes, elements and groups of a universal file.

    `leave_out` holds descriptors of elements, for example "136" for lumped masses.

    Raises
    ------
    InputError
        The file is not whole, holds its mesh in older datasets or coordinate systems of its own, or elements that are none of the body's.
    """
    datasets = _datasets(path, read_whole(path, LARGEST_FILE))
    old = [each for each in datasets if each.number in REFUSED]
    if old:
        what = f"its {REFUSED[old[0].number]} are in dataset {old[0].number}, which is not read"
        raise wrong_file(path, what, REMEDY, old[0].line)
    labels, points, systems = _nodes(path, [each for each in datasets if each.number in NODE_SETS])
    _refuse_systems(path, [each for each in datasets if each.number == 2420], systems)
    every = [found for each in datasets if each.number in ELEMENT_SETS for found in _elements(path, each)]
    Labels(path, np.concatenate([np.zeros(0, np.int64), *(each.labels for each in every)]), "element", REMEDY)
    elements, left_out = _wanted(path, every, leave_out)
    nodes = Labels(path, labels, "node", REMEDY)
    cells = [_cell(each, nodes) for each in elements]
    groups, remarks = _groups(path, [each for each in datasets if each.number in GROUP_SETS], nodes, elements, cells)
    told = [*_units(path, datasets), *remarks, *_skipped(datasets)]
    return MeshContents(points, cells, groups, labels, left_out=left_out, remarks=told)


def _datasets(path: Path, content: bytes) -> list[Dataset]:
    """All datasets in their order."""
    lines = content.split(b"\n")
    marks = [k for k, line in enumerate(lines) if line.strip() == b"-1"]
    if len(marks) < 2 or len(marks) % 2:
        raise wrong_file(path, "its lines of -1 do not enclose datasets, so that it is no universal file or not whole", REMEDY)
    found = []
    for start, end in zip(marks[::2], marks[1::2], strict=True):
        number = lines[start + 1].split()[:1]
        if not number or not number[0].isdigit() or len(number[0]) > 6:
            raise wrong_file(path, "a dataset has no number of text, or is binary", REMEDY, start + 2)
        found.append(Dataset(int(number[0]), start + 3, lines[start + 2 : end]))
    return found


def _nodes(path: Path, datasets: Sequence[Dataset]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Labels, places and coordinate systems of nodes: label, system, system of displacements, colour; x, y, z."""
    tables = []
    for each in datasets:
        found = numbers_of_text(path, each.numbers, each.line, REMEDY)
        if len(found) % 7:
            raise wrong_file(path, f"dataset {each.number} has not seven numbers for each node", REMEDY, each.line)
        tables.append(found.reshape(-1, 7))
    if not tables:
        raise wrong_file(path, "it has no dataset 2411 of nodes", REMEDY)
    table = np.concatenate(tables)
    whole = whole_numbers(path, table[:, :2], REMEDY)
    return whole[:, 0], table[:, 4:], np.unique(whole[:, 1])


def _refuse_systems(path: Path, datasets: Sequence[Dataset], used: np.ndarray) -> None:
    """Refuse nodes in a coordinate system that is cylindrical, spherical, turned or moved.

    Dataset 2420 has a part, its name, and of every system label, kind and colour, a name, and four rows of its axes and origin.
    """
    for each in datasets:
        for at in range(2, len(each.rows) - 5, 6):
            head = whole_numbers(path, numbers_of_text(path, each.rows[at], each.line + at, REMEDY), REMEDY)
            text = b"\n".join(each.rows[at + 2 : at + 6]).replace(b"D", b"E")
            axes = numbers_of_text(path, text, each.line + at + 2, REMEDY)
            if len(head) < 2 or len(axes) != 12:
                raise wrong_file(path, "dataset 2420 has a coordinate system without its numbers", REMEDY, each.line + at)
            plain = head[1] == 0 and np.allclose(axes.reshape(4, 3), np.eye(4, 3), rtol=0, atol=1e-12)
            if head[0] in used and not plain:
                raise wrong_file(
                    path,
                    "nodes are given in a coordinate system that is not the global Cartesian one",
                    "Export the nodes in the global system.",
                    each.line + at,
                )


def _elements(path: Path, dataset: Dataset) -> list[UniversalElement]:
    """Elements: label, descriptor, properties, material, colour, number of nodes; a row more for beams; nodes."""
    values = numbers_of_text(path, dataset.numbers, dataset.line, REMEDY)
    found = []
    for table in alike_rows(values, 0, (1, 5), lambda head: _width(head, len(values))):
        if table is None:
            raise wrong_file(path, "an element of dataset 2412 has not as many numbers as it says", REMEDY, dataset.line)
        rows = whole_numbers(path, table, REMEDY, dataset.line)
        descriptor, n = int(rows[0, 1]), int(rows[0, 5])
        kind = KINDS.get(descriptor)
        if kind is not None and n != NODES[kind]:
            raise wrong_file(path, f"an element of descriptor {descriptor} has not its {NODES[kind]} nodes", REMEDY, dataset.line)
        found.append(UniversalElement(descriptor, rows[:, 0], rows[:, -n:]))
    return found


def _width(head: np.ndarray, most: int) -> int:
    """Count of numbers in an element's record, from the first six of them; 0 if these are none of an element."""
    return 6 + 3 * (head[1] in BEAMS) + int(head[5]) if 1 <= head[5] <= most else 0


def _wanted(
    path: Path, every: Sequence[UniversalElement], leave_out: frozenset[str]
) -> tuple[list[UniversalElement], list[LeftOutContent]]:
    """Elements of the body, and what is left out on purpose."""
    present = {str(each.descriptor) for each in every}
    if leave_out - present:
        raise InputError(
            f"leave_out in [mesh] names {', '.join(sorted(leave_out - present))}, and {str(path)!r} has no elements of such a descriptor. "
            "Take it out of leave_out; a universal file knows elements by the number of their descriptor."
        )
    count: dict[int, int] = {}
    for each in every:
        if each.descriptor not in KINDS or str(each.descriptor) in leave_out:
            count[each.descriptor] = count.get(each.descriptor, 0) + len(each.labels)
    for descriptor, n in count.items():
        if str(descriptor) not in leave_out:
            raise InputError(
                f"the mesh {str(path)!r} has {n} elements of descriptor {descriptor} ({OTHERS.get(descriptor, 'not known')}), which are no "
                f'elements of solids. If the body is meant without them, add leave_out = ["{descriptor}"] to [mesh].'
            )
    kept = [each for each in every if each.descriptor not in count]
    return kept, [LeftOutContent(f"descriptor {key}", n, "leave_out in [mesh] names it") for key, n in count.items()]


def _cell(element: UniversalElement, labels: Labels) -> tuple[str, np.ndarray]:
    """Kind of elements, and their nodes as places among the points."""
    kind = KINDS[element.descriptor]
    nodes = labels.places(element.nodes)
    return kind, nodes[:, ORDERS[kind]] if kind in ORDERS else nodes


def _groups(
    path: Path, datasets: Sequence[Dataset], labels: Labels, elements: Sequence[UniversalElement], cells: Elements
) -> tuple[list[tuple[str, Elements]], list[str]]:
    """Groups with their nodes and elements, and remarks on what they name besides."""
    found: dict[str, Elements] = {}
    remarks = []
    for dataset in datasets:
        for name, members in _named(path, dataset).items():
            own = members[members[:, 0] == ELEMENT, 1]
            nodes = members[members[:, 0] == NODE, 1]
            parts: Elements = [("vertex", labels.places(nodes)[:, None])] if len(nodes) else []
            inside = [np.isin(each.labels, own) for each in elements]
            parts += [(kind, block[own_here]) for (kind, block), own_here in zip(cells, inside, strict=True) if own_here.any()]
            lost = len(members) - len(nodes) - sum(map(np.count_nonzero, inside))
            if name in found:
                raise wrong_file(path, "two groups have one name", "Give each group a name of its own.", dataset.line)
            found[name] = parts
            if lost:
                remarks.append(f"The group {name!r} names {lost} things besides nodes and elements of the file.")
    return list(found.items()), remarks


def _named(path: Path, dataset: Dataset) -> Mapping[str, np.ndarray]:
    """Names of groups, and code and label (n, 2) of all that they consist of."""
    found: dict[str, np.ndarray] = {}
    at = 0
    while at < len(dataset.rows):
        line = dataset.line + at
        head = whole_numbers(path, numbers_of_text(path, dataset.rows[at], line, REMEDY), REMEDY, line)
        if not len(head) and not any(row.strip() for row in dataset.rows[at:]):
            break
        if len(head) != 8 or head[-1] < 0 or at + 1 >= len(dataset.rows):
            raise wrong_file(
                path, f"a group of dataset {dataset.number} does not begin with eight numbers and a name", REMEDY, line
            )
        end = at + 2 + -(-int(head[-1]) // 2)
        text = b"\n".join(dataset.rows[at + 2 : end])
        members = whole_numbers(path, numbers_of_text(path, text, line + 2, REMEDY), REMEDY, line)
        if len(members) != 4 * head[-1]:
            raise wrong_file(path, f"a group of dataset {dataset.number} has not as many members as it says", REMEDY, line)
        name = dataset.rows[at + 1].strip().decode("utf-8", "backslashreplace") or f"group {head[0]}"
        if name in found:
            raise wrong_file(path, "two groups have one name", "Give each group a name of its own.", line)
        found[name] = members.reshape(-1, 4)[:, :2]
        at = end
    return found


def _units(path: Path, datasets: Sequence[Dataset]) -> list[str]:
    """Remark on the unit of lengths that the file names."""
    for each in datasets:
        if each.number == 164 and each.rows:
            code = each.rows[0][:10].strip()
            unit = UNITS.get(int(code), "") if code.isdigit() and len(code) < 4 else ""
            return [f"The file gives lengths in {unit}, by its dataset 164." if unit else "Dataset 164 names no known units."]
    return []


def _skipped(datasets: Sequence[Dataset]) -> list[str]:
    """Remark on datasets that are not part of the mesh."""
    read = {*NODE_SETS, *ELEMENT_SETS, *GROUP_SETS, 151, 164, 2420}
    others = sorted({each.number for each in datasets} - read)
    return [f"Datasets that are no part of the mesh were not read: {', '.join(map(str, others))}."] if others else []
