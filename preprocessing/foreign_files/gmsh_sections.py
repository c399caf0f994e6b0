"""Sections of a .msh file of gmsh: numbers, nodes, elements by gmsh's kinds, and physical groups."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from preprocessing.foreign_files.contents import Elements, Labels, MeshContents, numbers_of_text, whole_numbers, wrong_file
from toolkit.foundation.errors import InputError


class GmshKind(NamedTuple):
    """Kind of element of gmsh."""

    kind: str  # in the words of meshio
    nodes: int
    dimension: int


KINDS = {
    15: GmshKind("vertex", 1, 0),
    1: GmshKind("line", 2, 1),
    8: GmshKind("line3", 3, 1),
    26: GmshKind("line4", 4, 1),
    27: GmshKind("line5", 5, 1),
    28: GmshKind("line6", 6, 1),
    2: GmshKind("triangle", 3, 2),
    9: GmshKind("triangle6", 6, 2),
    20: GmshKind("triangle9", 9, 2),
    21: GmshKind("triangle10", 10, 2),
    22: GmshKind("triangle12", 12, 2),
    23: GmshKind("triangle15", 15, 2),
    24: GmshKind("triangle15", 15, 2),
    25: GmshKind("triangle21", 21, 2),
    3: GmshKind("quad", 4, 2),
    10: GmshKind("quad9", 9, 2),
    16: GmshKind("quad8", 8, 2),
    36: GmshKind("quad16", 16, 2),
    37: GmshKind("quad25", 25, 2),
    38: GmshKind("quad36", 36, 2),
    39: GmshKind("quad12", 12, 2),
    40: GmshKind("quad16", 16, 2),
    41: GmshKind("quad20", 20, 2),
    4: GmshKind("tetra", 4, 3),
    11: GmshKind("tetra10", 10, 3),
    29: GmshKind("tetra20", 20, 3),
    30: GmshKind("tetra35", 35, 3),
    31: GmshKind("tetra56", 56, 3),
    5: GmshKind("hexahedron", 8, 3),
    12: GmshKind("hexahedron27", 27, 3),
    17: GmshKind("hexahedron20", 20, 3),
    92: GmshKind("hexahedron64", 64, 3),
    93: GmshKind("hexahedron125", 125, 3),
    6: GmshKind("wedge", 6, 3),
    13: GmshKind("wedge18", 18, 3),
    18: GmshKind("wedge15", 15, 3),
    90: GmshKind("wedge40", 40, 3),
    91: GmshKind("wedge75", 75, 3),
    7: GmshKind("pyramid", 5, 3),
    14: GmshKind("pyramid14", 14, 3),
    19: GmshKind("pyramid13", 13, 3),
    118: GmshKind("pyramid30", 30, 3),
    119: GmshKind("pyramid55", 55, 3),
}
"""Number in gmsh -> the kind; those of third order and above are known in order to be refused by name."""

ORDERS = {
    "tetra10": [0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
    "hexahedron20": [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
    "hexahedron27": [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26],
    "wedge15": [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11],
}
"""Kind -> place in gmsh of every node of the order that is used here, where the two differ."""

DIMENSIONS = ("point", "curve", "surface", "volume")
"""Words of gmsh for entities of dimension 0 to 3."""


def reordered(kind: str, nodes: np.ndarray) -> np.ndarray:
    """Nodes (n_e, n_local) of elements of gmsh in the order that is used here."""
    return nodes[:, ORDERS[kind]] if kind in ORDERS else nodes


REMEDY = "Save it again with gmsh, as MSH 4.1 or 2.2."
HEAD = re.compile(rb"\$([A-Za-z0-9_]{1,40})[ \t\r]*(?:\n|$)")


class FileSection(NamedTuple):
    """Section of a file, between `$Name` and `$EndName`."""

    name: str
    line: int  # of its first line; 0 in a binary file
    body: bytes


def sections(path: Path, content: bytes, binary: bool) -> list[FileSection]:
    """All sections of a file in their order.

    Raises
    ------
    InputError
        A section has no end, or something stands outside of sections.
    """
    found: list[FileSection] = []
    at, line = 0, 1
    while at < len(content):
        after = _next_line(content, at)
        if content[at:after].strip():
            head = HEAD.match(content, at)
            if head is None:
                raise wrong_file(path, "a line stands outside of all sections", REMEDY, 0 if binary else line)
            end, after = _end(path, content, head, 0 if binary else line)
            found.append(FileSection(head[1].decode(), 0 if binary else line + 1, content[head.end() : end]))
        line += 0 if binary else content.count(b"\n", at, after)
        at = after
    return found


def _next_line(content: bytes, at: int) -> int:
    """Position at which the next line begins."""
    end = content.find(b"\n", at)
    return len(content) if end < 0 else end + 1


def _end(path: Path, content: bytes, head: re.Match[bytes], line: int) -> tuple[int, int]:
    """Positions at which the body of a section ends, and at which the line after the section begins."""
    for mark in (b"$End" + head[1], b"$END" + head[1]):  # the second in the first version
        at = content.find(b"\n" + mark, head.end() - 1)
        if at >= 0:
            return max(at, head.end()), _next_line(content, at + 1)
    raise wrong_file(path, "a section has no end, so that the file is not whole", REMEDY, line)


class SectionNumbers(Protocol):
    """Numbers of a section, which are taken one after the other."""

    def whole(self, n: int, kind: str = "int") -> np.ndarray:
        """The next n whole numbers, each an `int` or a `size` of gmsh."""

    def real(self, n: int) -> np.ndarray:
        """The next n real numbers."""

    def finish(self) -> None:
        """Refuse numbers that are left."""


class TextNumbers:
    """The numbers of a section of text."""

    def __init__(self, path: Path, section: FileSection) -> None:
        self.path, self.section, self.at = path, section, 0
        self.values = numbers_of_text(path, section.body, section.line, REMEDY)

    def real(self, n: int) -> np.ndarray:
        """The next n numbers."""
        if not 0 <= n <= len(self.values) - self.at:
            raise short(self.path, self.section)
        self.at += n
        return self.values[self.at - n : self.at]

    def table(self, n: int, width: int) -> np.ndarray:
        """The next n rows of so many numbers."""
        return self.real(n * width).reshape(n, width)

    def whole(self, n: int, kind: str = "int") -> np.ndarray:
        """The next n numbers, which have to be whole."""
        return self.as_whole(self.real(n))

    def as_whole(self, found: np.ndarray) -> np.ndarray:
        """Numbers that have to be whole."""
        return whole_numbers(self.path, found, REMEDY, self.section.line)

    def finish(self) -> None:
        """Refuse numbers that are left."""
        if self.at < len(self.values):
            raise wrong_file(self.path, f"${self.section.name} holds more numbers than it says", REMEDY)


class BinaryNumbers:
    """The numbers of a binary section; `size` is the number of bytes of a size, `order` that of bytes, "<" or ">"."""

    def __init__(self, path: Path, section: FileSection, size: int, order: str) -> None:
        self.path, self.section, self.at = path, section, 0
        self.types = {"int": f"{order}i4", "size": f"{order}i{size}", "real": f"{order}f8"}

    def real(self, n: int) -> np.ndarray:
        """The next n doubles."""
        return self._next(n, np.dtype(self.types["real"])).astype(float)

    def whole(self, n: int, kind: str = "int") -> np.ndarray:
        """The next n whole numbers of a kind."""
        return self._next(n, np.dtype(self.types[kind])).astype(np.int64)

    def rows(self, n: int, fields: list[tuple[str, str, tuple[int, ...]]]) -> np.ndarray:
        """The next n records, whose fields have a name, a kind of number and a shape."""
        return self._next(n, np.dtype([(name, self.types[kind], shape) for name, kind, shape in fields]))

    def _next(self, n: int, dtype: np.dtype) -> np.ndarray:
        if not 0 <= n * dtype.itemsize <= len(self.section.body) - self.at:
            raise short(self.path, self.section)
        found = np.frombuffer(self.section.body, dtype, n, self.at)
        self.at += n * dtype.itemsize
        return found

    def finish(self) -> None:
        """Refuse bytes that are left, besides the end of a line."""
        if self.section.body[self.at :].strip():
            raise wrong_file(self.path, f"${self.section.name} holds more bytes than it says", REMEDY)


def short(path: Path, section: FileSection) -> InputError:
    """Error of a section that claims more than it holds."""
    return wrong_file(path, f"${section.name} claims more numbers than it holds", REMEDY, section.line)


Group = tuple[int, int]
"""Dimension and positive tag of a physical group."""
NAME = re.compile(rb'\s*([0-3])\s+(-?\d{1,18})\s+"(.*)"\s*')


def names_of_groups(path: Path, section: FileSection) -> dict[Group, str]:
    """Names that $PhysicalNames gives to groups.

    Raises
    ------
    InputError
        A line is not dimension, tag and name in quotation marks, or there are more or fewer lines than the section says.
    """
    head, _, rest = section.body.strip().partition(b"\n")
    lines = [line for line in rest.split(b"\n") if line.strip()]
    if not head.strip().isdigit() or int(head.strip()[:18]) != len(lines):
        raise wrong_file(path, "$PhysicalNames has not as many lines as it says", REMEDY, section.line)
    names = {}
    for k, line in enumerate(lines):
        found = NAME.fullmatch(line)
        if found is None:
            raise wrong_file(
                path, "a line of $PhysicalNames is not dimension, tag and name in quotation marks", REMEDY, section.line + k + 1
            )
        names[int(found[1]), abs(int(found[2]))] = found[3].decode("utf-8", "backslashreplace")
    return names


def named_groups(members: Mapping[Group, Elements], names: Mapping[Group, str]) -> tuple[list[tuple[str, Elements]], list[str]]:
    """Groups by their names, and remarks that the user should know.

    A name that gmsh gives to groups of several dimensions stands for none of them alone: they are called, for example, "tip (curve 4)"
    and "tip (surface 2)". A group without a name is called after its dimension and tag, for example "physical surface 3".
    """
    every = dict.fromkeys([*names, *members])
    dimensions: dict[str, set[int]] = {}
    for dimension, tag in names:
        dimensions.setdefault(names[dimension, tag], set()).add(dimension)
    together: dict[str, list[Group]] = {}
    for group in every:
        together.setdefault(_name(group, names.get(group), dimensions), []).append(group)
    found = [(name, _union([members.get(group, []) for group in groups])) for name, groups in together.items()]
    return found, [*_remarks(dimensions, together), *_without_elements(names, members)]


def _name(group: Group, name: str | None, dimensions: Mapping[str, set[int]]) -> str:
    """Name of a group."""
    which = f"{DIMENSIONS[group[0]]} {group[1]}"
    if name is None:
        return f"physical {which}"
    return name if len(dimensions[name]) == 1 else f"{name} ({which})"


def _remarks(dimensions: Mapping[str, set[int]], together: Mapping[str, list[Group]]) -> list[str]:
    """Remarks on names of several groups."""
    several = [
        f"The name {name!r} is of groups of several dimensions ({', '.join(DIMENSIONS[each] for each in sorted(of))}), which are called "
        f"'{name} ({DIMENSIONS[max(of)]} TAG)' and so on."
        for name, of in dimensions.items()
        if len(of) > 1
    ]
    same = [
        f"The group {name!r} is made of {len(groups)} physical groups of this name."
        for name, groups in together.items()
        if len(groups) > 1
    ]
    return several + same


def _without_elements(names: Mapping[Group, str], members: Mapping[Group, Elements]) -> list[str]:
    """Remark that groups are named and have no elements, as gmsh writes MSH 2.2 with Mesh.SaveAll."""
    empty = [group for group in names if not members.get(group)]
    if not empty:
        return []
    return [
        f"{len(empty)} of {len(names)} named groups have no elements in the file. gmsh leaves groups out where it saves all elements "
        "(Mesh.SaveAll) in MSH 1 or 2.2: save MSH 4.1."
    ]


def _union(parts: list[Elements]) -> Elements:
    """All elements of several groups, each once."""
    if len(parts) == 1:
        return parts[0]
    kinds = dict.fromkeys(kind for part in parts for kind, _ in part)
    return [(kind, _once([nodes for part in parts for other, nodes in part if other == kind])) for kind in kinds]


def _once(blocks: list[np.ndarray]) -> np.ndarray:
    """Elements of several blocks without repetition, in their order; a curve may be in one group against its direction."""
    every = np.concatenate(blocks)
    _, first = np.unique(np.sort(every, axis=1), axis=0, return_index=True)
    return every[np.sort(first)]


class Nodes(NamedTuple):
    """Tags and places of all nodes."""

    tags: np.ndarray  # (n,)
    points: np.ndarray  # (n, 3)


class GmshBlock(NamedTuple):
    """Elements of one kind."""

    kind: GmshKind
    nodes: np.ndarray  # (n_e, n_local), tags in the order of gmsh
    groups: Sequence[tuple[int, np.ndarray | slice]]  # tag of a physical group, and which of the elements are in it


def known_kind(path: Path, number: int) -> GmshKind:
    """The kind of element with a number in gmsh.

    Raises
    ------
    InputError
        It is none of those that are known here.
    """
    if number not in KINDS:
        raise wrong_file(
            path,
            "it holds elements besides points, lines, triangles, quadrilaterals, tetrahedra, hexahedra, prisms and pyramids",
            "Mesh the body with these.",
        )
    return KINDS[number]


def contents(
    path: Path, nodes: Nodes, blocks: Sequence[GmshBlock], names: dict[Group, str], remarks: Sequence[str]
) -> MeshContents:
    """The record of a mesh: nodes counted from 0, and groups by their names."""
    labels = Labels(path, nodes.tags, "node", REMEDY)
    cells: Elements = []
    members: dict[Group, Elements] = {}
    for block in blocks:
        cells.append((block.kind.kind, reordered(block.kind.kind, labels.places(block.nodes))))
        for tag, own in block.groups:
            members.setdefault((block.kind.dimension, tag), []).append((block.kind.kind, cells[-1][1][own]))
    groups, told = named_groups(members, names)
    return MeshContents(nodes.points, cells, groups, nodes.tags, remarks=[*remarks, *told])
