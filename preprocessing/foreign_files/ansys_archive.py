"""Archives of Ansys Mechanical APDL, .cdb, as CDWRITE writes them: blocks of nodes, elements and components between commands."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.child import LARGEST_FILE
from preprocessing.foreign_files.contents import (
    Elements,
    Labels,
    LeftOutContent,
    MeshContents,
    numbers_of_text,
    whole_numbers,
    wrong_file,
)
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import read_whole

SOLIDS = {**dict.fromkeys((45, 64, 65, 185), 8), **dict.fromkeys((95, 186), 20), **dict.fromkeys((92, 187), 10), 285: 4}
"""Type of structural solid -> its number of nodes."""
PLANES = {**dict.fromkeys((42, 182), 4), **dict.fromkeys((82, 183), 8), 2: 6}
"""Type of structural element of the plane -> its number of nodes."""
USED = SOLIDS | PLANES
NAMES = {
    3: "BEAM3", 4: "BEAM4", 8: "LINK8", 10: "LINK10", 14: "COMBIN14", 21: "MASS21", 39: "COMBIN39", 40: "COMBIN40", 43: "SHELL43",
    63: "SHELL63", 93: "SHELL93", 152: "SURF152", 153: "SURF153", 154: "SURF154", 156: "SURF156", 169: "TARGE169", 170: "TARGE170",
    173: "CONTA173", 174: "CONTA174", 175: "CONTA175", 176: "CONTA176", 177: "CONTA177", 180: "LINK180", 181: "SHELL181",
    184: "MPC184", 188: "BEAM188", 189: "BEAM189", 190: "SOLSH190", 200: "MESH200", 214: "COMBI214", 250: "COMBI250", 281: "SHELL281",
}  # fmt: skip
"""Types that are often beside solids; others are called by their number."""
LINEAR = {"hexahedron": list(range(8)), "wedge": [0, 1, 2, 4, 5, 6], "tetra": [0, 1, 2, 4], "pyramid": [0, 1, 2, 3, 4]}
QUADRATIC = {
    "hexahedron20": list(range(20)),
    "wedge15": [0, 1, 2, 4, 5, 6, 8, 9, 11, 12, 13, 15, 16, 17, 18],
    "tetra10": [0, 1, 2, 4, 8, 9, 11, 16, 17, 18],
    "pyramid13": [0, 1, 2, 3, 4, 8, 9, 10, 11, 16, 17, 18, 19],
}
"""Kind -> those of the nodes of a brick that it keeps, where others fall on them."""
REMEDY = "Write it again with CDWRITE,DB from Ansys."


def element_name(number: int) -> str:
    """Name of an element type, for example SHELL181."""
    return NAMES.get(number, f"type {number}")


class ElementShape(NamedTuple):
    """Elements of one kind among those of a type."""

    kind: str
    own: np.ndarray  # (n_e,) rows of the table
    columns: list[int]  # places of their nodes in a row


def shapes(path: Path, number: int, nodes: np.ndarray) -> list[ElementShape]:
    """The kinds of elements of one type; `nodes` (n_e, n) holds labels, 0 for nodes that are not given.

    Raises
    ------
    InputError
        Some of the nodes between corners are missing, or corners fall together in a way that gives no element.
    """
    most = USED[number]
    corners = {20: 8, 10: 4, 6: 3}.get(most, 4 if number in PLANES else most)
    given = np.count_nonzero(nodes, axis=1)
    rows = {n: np.flatnonzero(given == n) for n in np.unique(given).tolist()}
    if any(not np.all(nodes[own, :n]) or not _possible(number, n, corners) for n, own in rows.items()):
        raise wrong_file(
            path, f"an element of {element_name(number)} lacks some of its nodes", "Mesh the body with all middle nodes, or none."
        )
    found = [each for n, own in rows.items() for each in _of_one_size(path, nodes, own, n, number in PLANES)]
    return [each for each in found if len(each.own)]


def _possible(number: int, n: int, corners: int) -> bool:
    """Whether an element of a type may have so many nodes: all of them, its corners, or six as a triangle of the plane."""
    return n in (USED[number], corners) or (n == 6 and number in (82, 183))


def _of_one_size(path: Path, nodes: np.ndarray, own: np.ndarray, n: int, plane: bool) -> list[ElementShape]:
    """Kinds of elements of n nodes."""
    whole = {(4, False): "tetra", (10, False): "tetra10", (3, True): "triangle", (6, True): "triangle6"}.get((n, plane))
    found = [ElementShape(whole, own, list(range(n)))] if whole else (_plane if plane else _bricks)(path, nodes, own, n)
    for each in found:
        rising = np.sort(nodes[each.own][:, each.columns], axis=1)
        if np.any(rising[:, 1:] == rising[:, :-1]):
            raise wrong_file(path, f"a {each.kind} has a node twice", REMEDY)
    return found


def _plane(_path: Path, nodes: np.ndarray, own: np.ndarray, n: int) -> list[ElementShape]:
    """Quadrilaterals of the plane, and triangles where K = L in the letters of Ansys."""
    flat = nodes[own, 2] == nodes[own, 3]
    if n == 4:
        return [ElementShape("quad", own[~flat], [0, 1, 2, 3]), ElementShape("triangle", own[flat], [0, 1, 2])]
    return [ElementShape("quad8", own[~flat], list(range(8))), ElementShape("triangle6", own[flat], [0, 1, 2, 4, 5, 7])]


def _bricks(path: Path, nodes: np.ndarray, own: np.ndarray, n: int) -> list[ElementShape]:
    """Bricks, wedges (K = L, O = P), tetrahedra (K = L, M = N = O = P) and pyramids (M = N = O = P)."""
    low = nodes[own, 2] == nodes[own, 3]
    high = nodes[own, 6] == nodes[own, 7]
    top = high & (nodes[own, 4] == nodes[own, 5]) & (nodes[own, 4] == nodes[own, 6])
    which = [~low & ~high, low & high & ~top, low & top, ~low & top]
    if not np.all(np.sum(which, axis=0) == 1):
        raise wrong_file(path, "corners of a brick fall together in a way that gives no wedge, tetrahedron or pyramid", REMEDY)
    kinds = LINEAR if n == 8 else QUADRATIC
    return [ElementShape(kind, own[here], columns) for here, (kind, columns) in zip(which, kinds.items(), strict=True)]


FORM = re.compile(
    rb"\s*\(\s*(\d{1,2})i(\d{1,2})(?:\s*,\s*(\d)[eEgG](\d{1,2})\.\d+(?:[eE]\d)?)?(?:,\d+a\d+)?\s*\)\s*", re.IGNORECASE
)
CHANGES = {
    "E", "EMORE", "NGEN", "EGEN", "ENGEN", "NSYM", "ESYM", "ENSYM", "NSCALE", "NDELE", "EDELE", "EMODIF", "NMODIF", "NUMMRG", "NUMCMP",
    "CDREAD", "/INPUT", "*USE", "*DO", "NREAD", "EREAD", "TRANSFER", "FILL", "VMESH", "AMESH", "LMESH", "EINTF", "ESURF", "MOVE", "NROTAT",
}  # fmt: skip
"""Commands that would change nodes and elements, which an archive states instead."""
AXISYMMETRIC = (["1"], ["6"])
"""Values of KEYOPT(3) with which a plane element is a ring."""
TIES = {"CP", "CPNGEN", "CPINTF", "CE", "CEINTF", "CERIG", "RBE3"}
"""Commands that tie nodes to each other."""


@dataclass
class Archive:
    """State of reading an archive: what has been read so far."""

    path: Path
    lines: list[bytes]
    at: int = 0  # the line that is next
    types: dict[int, int] = field(default_factory=dict)  # number of a local type -> type of Ansys
    nodes: list[np.ndarray] = field(default_factory=list)  # tables of label, x, y, z
    elements: list[np.ndarray] = field(default_factory=list)  # tables of label, local type, nodes
    components: dict[str, tuple[bool, np.ndarray]] = field(default_factory=dict)  # name -> of elements or not, labels
    axisymmetric: set[int] = field(default_factory=set)  # local types with KEYOPT(3) = 1 or 6, which plane ones have
    ties: dict[str, int] = field(default_factory=dict)
    others: int = 0  # commands that say nothing of the mesh

    def wrong(self, what: str) -> InputError:
        """Error of the command before the next line."""
        return wrong_file(self.path, what, REMEDY, self.at)

    def count(self, words: list[str], k: int) -> int | None:
        """Count from the k-th word of a command; None where it is empty."""
        word = words[k] if len(words) > k else ""
        if word and not (word.isascii() and word.isdigit() and len(word) < 12):
            raise self.wrong(f"{words[0]} has other words than counts")
        return int(word) if word else None

    def block(self, ends: Callable[[bytes], bool]) -> list[bytes]:
        """Lines up to one that ends the block, which is passed too."""
        start = self.at
        while self.at < len(self.lines) and not ends(self.lines[self.at]):
            self.at += 1
        if self.at == len(self.lines):
            self.at = start
            raise self.wrong("a block has no end, so that the file is not whole")
        self.at += 1
        return [line for line in self.lines[start : self.at - 1] if line.strip()]

    def form(self) -> tuple[int, int, int]:
        """The format of a block: number and width of whole numbers, and width of real ones."""
        found = FORM.fullmatch(self.lines[self.at]) if self.at < len(self.lines) else None
        if found is None or not int(found[1]) or not int(found[2]):
            raise self.wrong("a block begins without a format such as (19i10)")
        self.at += 1
        return int(found[1]), int(found[2]), int(found[4] or 0)


def ansys_mesh(path: Path, leave_out: frozenset[str]) -> MeshContents:
    """Nodes, elements and components of a .cdb file.

    `leave_out` holds names of element types, for example "SHELL181", and of commands that tie nodes.

    Raises
    ------
    InputError
        The file is no archive or not whole, changes its mesh by commands, or has elements or ties that are not read here.
    """
    archive = Archive(path, read_whole(path, LARGEST_FILE).replace(b"\r", b"").split(b"\n"))
    while archive.at < len(archive.lines):
        _command(archive)
    if not archive.nodes or not archive.elements:
        raise wrong_file(path, f"it has no {'EBLOCK with elements' if archive.nodes else 'NBLOCK with nodes'}", REMEDY)
    nodes, elements = np.concatenate(archive.nodes), np.concatenate(archive.elements)
    labels = whole_numbers(path, nodes[:, 0], REMEDY)
    places = Labels(path, labels, "node", REMEDY)
    kept, left_out = _wanted(archive, elements, leave_out)
    cells: Elements = []
    of: list[np.ndarray] = []
    for number, rows in kept.items():
        for shape in shapes(path, number, rows[:, 2:]):
            cells.append((shape.kind, places.places(rows[shape.own][:, 2:][:, shape.columns])))
            of.append(rows[shape.own, 0])
    groups, remarks = _groups(archive, places, elements[:, 0], cells, of)
    if archive.others:
        remarks.append(f"{archive.others} lines that say nothing of nodes, elements and components were not read.")
    return MeshContents(nodes[:, 1:], cells, groups, labels, left_out=left_out, remarks=remarks)


def _command(archive: Archive) -> None:
    """Read the next line, and the block that it opens."""
    line = archive.lines[archive.at]
    archive.at += 1
    words = [word.strip().upper() for word in line.partition(b"!")[0].decode("latin-1").split(",")]
    if words[0] in READ:
        READ[words[0]](archive, words)
    elif words[0] in CHANGES:
        raise archive.wrong(f"the command {words[0]} changes nodes or elements, which are not read from commands")
    elif words[0] in TIES:
        archive.ties[words[0]] = archive.ties.get(words[0], 0) + 1
    elif words[0]:
        archive.others += 1


def _type(archive: Archive, words: list[str]) -> None:
    """Read ET, number, type."""
    local, digits = archive.count(words, 1), re.sub(r"\D", "", words[2]) if len(words) > 2 else ""
    if local is None or not digits or len(digits) > 6:
        raise archive.wrong("ET has no number and type")
    archive.types[local] = int(digits)
    if words[5:6] in AXISYMMETRIC:
        archive.axisymmetric.add(local)


def _types(archive: Archive, words: list[str]) -> None:
    """Read ETBLOCK: rows of number, type and key options, up to -1."""
    _, width, _ = archive.form()
    rows = archive.block(_minus_one)
    table = _fields(archive, [row[: 5 * width] for row in rows], 5, width)
    for local, number, _, _, third in table.tolist():
        archive.types[local] = number
        if [str(third)] in AXISYMMETRIC:
            archive.axisymmetric.add(local)


def _option(archive: Archive, words: list[str]) -> None:
    """Read KEYOPT, number of the local type, of the option, value; only the third option of plane elements counts."""
    local = archive.count(words, 1)
    if local is not None and words[2:3] == ["3"] and words[3:4] in AXISYMMETRIC:
        archive.axisymmetric.add(local)


def _node_block(archive: Archive, words: list[str]) -> None:
    """Read NBLOCK: rows of label, with SOLID two numbers of a solid model, and x, y, z, of which last zeros are left out."""
    count = archive.count(words, 4)
    n_whole, width, real = archive.form()
    if not real or n_whole not in (1, 3):
        raise archive.wrong("NBLOCK has another format than (3i9,6e21.13) or (1i9,3e21.13)")
    rows = archive.block(lambda line: line.lstrip()[:1].isalpha() or _minus_one(line))
    if _minus_one(archive.lines[archive.at - 1]) is False:
        archive.at -= 1  # the command behind it is a line of its own
    start = n_whole * width
    label = _fields(archive, [row[:width] for row in rows], 1, width)
    text = [row[start : start + 3 * real].replace(b"D", b"E").replace(b"d", b"e") for row in rows]
    archive.nodes.append(np.hstack([label, _fields(archive, text, 3, real, True)]))
    if count not in (None, len(rows)):
        raise archive.wrong("NBLOCK has not as many nodes as it says")


def _element_block(archive: Archive, words: list[str]) -> None:
    """Read EBLOCK with SOLID.

    Rows of material, type, real constants, section, system, death, model, shape, number of nodes, -, label, nodes.
    """
    if words[2:3] != ["SOLID"]:
        raise archive.wrong("EBLOCK without SOLID, as Workbench writes it for its solver, is not read")
    count = archive.count(words, 4)
    n, width, _ = archive.form()
    if n != 19:
        raise archive.wrong("EBLOCK has another format than 19 numbers a line")
    table = _fields(archive, archive.block(_minus_one), n, width)
    at, starts = 0, []
    sizes = table[:, 8].tolist()
    while at < len(table):
        starts.append(at)
        if not 1 <= sizes[at] <= 27:
            raise archive.wrong("an element of EBLOCK has no number of nodes")
        at += 2 if sizes[at] > 8 else 1
    first = np.array(starts, np.int64)
    if at != len(table) or count not in (None, len(first)):
        raise archive.wrong("EBLOCK has not as many elements as it says")
    more = np.where((table[first, 8] > 8)[:, None], table[np.minimum(first + 1, len(table) - 1)], 0)
    nodes = np.hstack([table[first, 11:], more])
    nodes[np.arange(nodes.shape[1]) >= table[first, 8, None]] = 0
    archive.elements.append(np.hstack([table[first][:, [10, 1]], nodes]))


def _component(archive: Archive, words: list[str]) -> None:
    """Read CMBLOCK: labels of nodes or elements, of which a negative one ends a range."""
    count = archive.count(words, 3)
    if len(words) < 4 or words[2] not in ("NODE", "ELEM", "ELEMENT") or count is None:
        raise archive.wrong("CMBLOCK is not of nodes or elements, with their number")
    name = archive.lines[archive.at - 1].split(b",")[1].strip().decode("utf-8", "backslashreplace")
    n, width, _ = archive.form()
    n_rows = -(-count // n)
    rows = archive.lines[archive.at : archive.at + n_rows]
    archive.at += n_rows
    flat = _fields(archive, rows, n, width).ravel()[:count]
    if len(flat) < count or not np.all(flat) or np.any(flat[:1] < 0) or np.any((flat[1:] < 0) & (flat[:-1] < 0)):
        raise archive.wrong("CMBLOCK has not as many labels as it says, or a range without a start")
    if name in archive.components:
        raise archive.wrong("a component is there twice")
    archive.components[name] = (words[2] != "NODE", flat)


def _node(archive: Archive, words: list[str]) -> None:
    """Read N or EN, of which only the line with -1 that ends a block is known."""
    if "-1" not in words:
        raise archive.wrong(f"the command {words[0]} gives single nodes or elements, which are read from blocks only")


READ: dict[str, Callable[[Archive, list[str]], None]] = {
    "ET": _type, "ETBLOCK": _types, "KEYOP": _option, "KEYOPT": _option, "NBLOCK": _node_block, "EBLOCK": _element_block,
    "CMBLOCK": _component, "N": _node, "EN": _node,
}  # fmt: skip
"""Commands that are read."""


def _minus_one(line: bytes) -> bool:
    return line.strip() == b"-1"


def _fields(archive: Archive, rows: list[bytes], n: int, width: int, real: bool = False) -> np.ndarray:
    """Numbers in n columns of one width, (n_rows, n); what is blank is 0."""
    if not rows:
        return np.zeros((0, n), float if real else np.int64)
    if max(map(len, rows)) > n * width and any(row[n * width :].strip() for row in rows):
        raise archive.wrong("a line of the block before is longer than its format")
    text = b"".join(row[: n * width].ljust(n * width) for row in rows)
    letters = np.frombuffer(text, np.uint8).reshape(-1, width)
    apart = np.full((len(letters), width + 1), ord(" "), np.uint8)
    apart[:, :width] = letters
    apart[np.all(letters == ord(" "), axis=1), 0] = ord("0")
    found = numbers_of_text(archive.path, apart.tobytes(), 0, REMEDY)
    if found.size != len(rows) * n:
        raise archive.wrong("a column of the block before has no single number")
    found = found.reshape(-1, n)
    return found if real else whole_numbers(archive.path, found, REMEDY, archive.at)


def _wanted(
    archive: Archive, elements: np.ndarray, leave_out: frozenset[str]
) -> tuple[dict[int, np.ndarray], list[LeftOutContent]]:
    """Rows of the elements of every type that is used, and what is left out on purpose."""
    unknown = set(elements[:, 1].tolist()) - set(archive.types)
    if unknown:
        raise wrong_file(archive.path, "an element is of a type that no ET defines", REMEDY)
    kept: dict[int, list[np.ndarray]] = {}
    beside: dict[str, int] = dict(archive.ties)
    for local in np.unique(elements[:, 1]).tolist():
        number, own = archive.types[local], np.flatnonzero(elements[:, 1] == local)
        if number not in USED or element_name(number).upper() in leave_out:
            beside[element_name(number)] = beside.get(element_name(number), 0) + len(own)
            continue
        if number in PLANES and local in archive.axisymmetric:
            raise wrong_file(
                archive.path,
                f"elements of type {number} have KEYOPT(3), so that they are axisymmetric or plane with another state",
                "Give a mesh of solids, or set KEYOPT(3) to 0.",
            )
        kept.setdefault(number, []).append(own)
    _refuse_beside(archive.path, beside, leave_out)
    left_out = [LeftOutContent(name, count, "leave_out in [mesh] names it") for name, count in beside.items()]
    return {number: elements[np.concatenate(rows)] for number, rows in kept.items()}, left_out


def _refuse_beside(path: Path, beside: dict[str, int], leave_out: frozenset[str]) -> None:
    """Refuse what stands beside the body and is not named to be left out, and names of what is not there."""
    for name, count in beside.items():
        if name.upper() not in leave_out:
            raise InputError(
                f"the mesh {str(path)!r} has {count} times {name}, which is not read. If the body is meant without it, add "
                f'leave_out = ["{name}"] to [mesh].'
            )
    if absent := leave_out - {name.upper() for name in beside}:
        raise InputError(
            f"leave_out in [mesh] names {', '.join(sorted(absent))}, which {str(path)!r} does not hold. Take it out of leave_out."
        )


def _groups(
    archive: Archive, places: Labels, labels: np.ndarray, cells: Elements, of: list[np.ndarray]
) -> tuple[list[tuple[str, Elements]], list[str]]:
    """Components with their nodes or elements, and remarks on what they name besides.

    `labels` are those of all elements, and `of` those of the elements in each block of `cells`.
    """
    Labels(archive.path, labels, "element", REMEDY)
    groups, remarks = [], []
    for name, (of_elements, ranges) in archive.components.items():
        if of_elements:
            inside = [_within(each, ranges) for each in of]
            members: Elements = [(kind, nodes[own]) for (kind, nodes), own in zip(cells, inside, strict=True) if own.any()]
            others = int(_within(labels, ranges).sum()) - sum(map(np.count_nonzero, inside))
            if others:
                remarks.append(f"The component {name!r} has {others} elements that are no part of the body.")
        else:
            members = [("vertex", places.order[_within(places.rising, ranges)][:, None])]
        groups.append((name, members))
    return groups, remarks


def _within(labels: np.ndarray, ranges: np.ndarray) -> np.ndarray:
    """Which labels are in a list of labels and ranges, in which a negative label ends the range that the one before begins."""
    starts = np.flatnonzero(ranges > 0)
    low = ranges[starts]
    after = np.append(ranges[1:], 0)[starts]
    high = np.where(after < 0, -after, low)
    order = np.argsort(low, kind="stable")
    low, high = low[order], np.maximum.accumulate(high[order])
    at = np.searchsorted(low, labels, side="right") - 1
    return (at >= 0) & (labels <= high[np.maximum(at, 0)]) if len(low) else np.zeros(len(labels), bool)
