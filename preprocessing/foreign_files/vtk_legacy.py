"""Files of VTK's simple format, .vtk, as text and binary, and the cells of VTK by their types."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from preprocessing.foreign_files.child import LARGEST_FILE
from preprocessing.foreign_files.contents import (
    Elements,
    MeshContents,
    numbers_of_text,
    refuse_leave_out,
    whole_numbers,
    wrong_file,
)
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import read_whole

REMEDY = "Export it again, with cells such as VTK_TETRA, VTK_HEXAHEDRON or their quadratic kinds."
TYPES = {
    1: ("vertex", 1), 3: ("line", 2), 5: ("triangle", 3), 8: ("quad", 4), 9: ("quad", 4), 10: ("tetra", 4), 11: ("hexahedron", 8),
    12: ("hexahedron", 8), 13: ("wedge", 6), 14: ("pyramid", 5), 21: ("line3", 3), 22: ("triangle6", 6), 23: ("quad8", 8),
    24: ("tetra10", 10), 25: ("hexahedron20", 20), 26: ("wedge15", 15), 27: ("pyramid13", 13), 28: ("quad9", 9),
    29: ("hexahedron27", 27),
}  # fmt: skip
"""Number in VTK -> kind of element, and its number of nodes."""
ORDERS = {8: [0, 1, 3, 2], 11: [0, 1, 3, 2, 4, 5, 7, 6], 13: [0, 2, 1, 3, 5, 4]}
"""Number in VTK -> place there of every node, where it counts them otherwise: pixels, voxels, and wedges, whose base looks outward."""
EMPTY = 0
"""Number of a cell without nodes, which is none."""
OTHERS = {
    2: "VTK_POLY_VERTEX", 4: "VTK_POLY_LINE", 6: "VTK_TRIANGLE_STRIP", 7: "VTK_POLYGON", 15: "VTK_PENTAGONAL_PRISM",
    16: "VTK_HEXAGONAL_PRISM", 30: "VTK_QUADRATIC_LINEAR_QUAD", 31: "VTK_QUADRATIC_LINEAR_WEDGE", 32: "VTK_BIQUADRATIC_QUADRATIC_WEDGE",
    33: "VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON", 34: "VTK_BIQUADRATIC_TRIANGLE", 35: "VTK_CUBIC_LINE", 36: "VTK_QUADRATIC_POLYGON",
    37: "VTK_TRIQUADRATIC_PYRAMID", 41: "VTK_CONVEX_POINT_SET", 42: "VTK_POLYHEDRON", 68: "VTK_LAGRANGE_CURVE",
    69: "VTK_LAGRANGE_TRIANGLE", 70: "VTK_LAGRANGE_QUADRILATERAL", 71: "VTK_LAGRANGE_TETRAHEDRON", 72: "VTK_LAGRANGE_HEXAHEDRON",
    73: "VTK_LAGRANGE_WEDGE", 74: "VTK_LAGRANGE_PYRAMID", 75: "VTK_BEZIER_CURVE", 76: "VTK_BEZIER_TRIANGLE",
    77: "VTK_BEZIER_QUADRILATERAL", 78: "VTK_BEZIER_TETRAHEDRON", 79: "VTK_BEZIER_HEXAHEDRON", 80: "VTK_BEZIER_WEDGE",
    81: "VTK_BEZIER_PYRAMID",
}  # fmt: skip
"""Numbers and names of cells that are refused."""


def cells_by_type(path: Path, types: np.ndarray, ends: np.ndarray, connectivity: np.ndarray) -> Elements:
    """Elements by kind, of cells whose nodes stand one behind the other and end at given places.

    Raises
    ------
    InputError
        A cell is of a type that is not supported, or has another number of nodes than its type.
    """
    starts = np.append(0, ends[:-1])
    if len(types) != len(ends) or np.any(ends < starts) or (len(ends) and ends[-1] != len(connectivity)):
        raise wrong_file(path, "the numbers of its cells, types and nodes contradict each other", REMEDY)
    cells = []
    for number in np.unique(types).tolist():
        own = np.flatnonzero(types == number)
        kind, n = _kind(path, number, len(own))
        if np.any(ends[own] - starts[own] != n):
            raise wrong_file(path, f"a cell of type {number} has not the {n} nodes of its type", REMEDY)
        nodes = connectivity[starts[own, None] + np.arange(n)]
        if number != EMPTY:
            cells.append((kind, (nodes[:, ORDERS[number]] if number in ORDERS else nodes).astype(np.int64)))
    return cells


def _kind(path: Path, number: int, count: int) -> tuple[str, int]:
    """Kind and number of nodes of the cells of a type."""
    if number == EMPTY:
        return "", 0
    if number not in TYPES:
        name = OTHERS.get(number, "a type that VTK does not list")
        raise wrong_file(path, f"{count} of its cells are {name}, which is no element here", REMEDY)
    return TYPES[number]


def grid_cells(path: Path, dimensions: tuple[int, ...]) -> Elements:
    """Quadrilaterals or hexahedra of a grid of so many points along x, y and z, of which x counts fastest."""
    long = [k for k in range(3) if dimensions[k] > 1]
    if len(long) < 2:
        raise wrong_file(path, "its grid is a point or a line", REMEDY)
    strides = np.cumprod([1, *dimensions[:2]])
    first = np.zeros(1, np.int64)
    for k in long:
        first = (first[None, :] + strides[k] * np.arange(dimensions[k] - 1)[:, None]).ravel()
    a, b = strides[long[0]], strides[long[1]]
    base = first[:, None] + np.array([0, a, a + b, b])
    return [("quad", base) if len(long) == 2 else ("hexahedron", np.hstack([base, base + strides[2]]))]


def hidden(path: Path) -> InputError:
    """Error of a mesh with ghosts."""
    return wrong_file(path, "it marks cells as ghosts or hidden (vtkGhostType)", "Export the whole body without ghost cells.")


HEAD = re.compile(rb"# vtk DataFile Version (\d)\.(\d)[ \t\r]*\n.*\n[ \t]*(ASCII|BINARY)[ \t\r]*\n", re.IGNORECASE)
WORD = re.compile(rb"^[ \t]*[A-Za-z_]", re.MULTILINE)
NUMBERS = {
    "char": "i1", "unsigned_char": "u1", "short": "i2", "unsigned_short": "u2", "int": "i4", "unsigned_int": "u4", "long": "i8",
    "unsigned_long": "u8", "float": "f4", "double": "f8", "vtkidtype": "i4", "vtktypeint32": "i4", "vtktypeint64": "i8",
    "vtktypeuint32": "u4", "vtktypeuint64": "u8",
}  # fmt: skip
"""Type of numbers in VTK -> that in NumPy."""
GRIDS = ("UNSTRUCTURED_GRID", "STRUCTURED_GRID", "RECTILINEAR_GRID", "STRUCTURED_POINTS")


class LegacyFile:
    """Legacy VTK file, of which one section after the other is read."""

    def __init__(self, path: Path, content: bytes) -> None:
        head = HEAD.match(content)
        if head is None:
            raise wrong_file(path, "it does not begin with '# vtk DataFile Version', a title, and ASCII or BINARY", REMEDY)
        self.path, self.content, self.at = path, content, head.end()
        self.binary = head[3].upper() == b"BINARY"
        self.found: dict[str, np.ndarray] = {}

    @property
    def line(self) -> int:
        """Number of the line that is read now; 0 in a binary file."""
        return 0 if self.binary else self.content.count(b"\n", 0, self.at) + 1

    def words(self) -> list[str]:
        """Words of the next line that has some; none at the end of the file."""
        while self.at < len(self.content):
            end = self.content.find(b"\n", self.at) + 1 or len(self.content)
            line, self.at = self.content[self.at : end], end
            if line.strip():
                return line[:1000].decode("latin-1").split()
        return []

    def whole(self, words: list[str], k: int) -> int:
        """Count from the k-th word of a line."""
        if len(words) <= k or not words[k].isascii() or not words[k].isdigit() or len(words[k]) > 15:
            raise wrong_file(self.path, f"{words[0]} is without its counts", REMEDY, max(self.line - 1, 0))
        return int(words[k])

    def numbers(self, n: int, kind: str) -> np.ndarray:
        """Next n numbers of a type of VTK."""
        if kind.lower() not in NUMBERS:
            raise wrong_file(self.path, "a list of numbers is of a type that VTK does not have", REMEDY, max(self.line - 1, 0))
        dtype = np.dtype(NUMBERS[kind.lower()]).newbyteorder(">")
        if not self.binary:
            return self._text(n, dtype.kind == "f")
        if n * dtype.itemsize > len(self.content) - self.at:
            raise wrong_file(self.path, "it claims more numbers than it holds", REMEDY)
        self.at += n * dtype.itemsize
        return np.frombuffer(self.content, dtype, n, self.at - n * dtype.itemsize).astype(dtype.newbyteorder("="))

    def _text(self, n: int, real: bool) -> np.ndarray:
        """Numbers up to the next line that begins with a word."""
        line = self.line
        after = WORD.search(self.content, self.at)
        end = after.start() if after else len(self.content)
        found = numbers_of_text(self.path, self.content[self.at : end], line, REMEDY)
        if len(found) != n:
            raise wrong_file(self.path, "there are more or fewer numbers than the line before says", REMEDY, line)
        self.at = end
        return found if real else whole_numbers(self.path, found, REMEDY, line)


def legacy_vtk(path: Path, leave_out: frozenset[str]) -> MeshContents:
    """Points and cells of a .vtk file with an unstructured, structured or rectilinear grid.

    Raises
    ------
    InputError
        It holds no such grid, or is not whole; or a cell is of a type that is no element here.
    """
    refuse_leave_out(path, leave_out, "VTK names nothing that could be")
    file = LegacyFile(path, read_whole(path, LARGEST_FILE))
    words = file.words()
    grid = words[1].upper() if len(words) == 2 and words[0].upper() == "DATASET" else ""
    if grid not in GRIDS:
        raise wrong_file(path, f"its DATASET is none of {', '.join(GRIDS)}", "Export the elements of the body.")
    while _section(file, file.words()):
        pass
    if file.content.find(b"vtkGhost", file.at) >= 0:
        raise hidden(path)
    return _unstructured(file) if grid == GRIDS[0] else _structured(file, grid)


def _section(file: LegacyFile, words: list[str]) -> bool:
    """Read a section of the grid; returns whether there may be more."""
    name = words[0].upper() if words else ""
    if name in ("", "POINT_DATA", "CELL_DATA"):
        return False
    if name not in SECTIONS:
        raise wrong_file(file.path, "a section is none of VTK's", REMEDY, max(file.line - 1, 0))
    SECTIONS[name](file, words)
    return True


def _points(file: LegacyFile, words: list[str]) -> None:
    file.found["POINTS"] = file.numbers(3 * file.whole(words, 1), words[2] if len(words) > 2 else "").reshape(-1, 3)


def _cells(file: LegacyFile, words: list[str]) -> None:
    """Cells as rows of a count and nodes, up to version 4; since 5 the places where they end, and all nodes."""
    n, size = file.whole(words, 1), file.whole(words, 2)
    before = file.at
    after = file.words()
    if after[:1] == ["OFFSETS"]:
        file.found["ENDS"] = file.numbers(n, after[1] if len(after) > 1 else "")[1:]
        after = file.words()
        if after[:1] != ["CONNECTIVITY"]:
            raise wrong_file(file.path, "CELLS has OFFSETS without CONNECTIVITY", REMEDY, max(file.line - 1, 0))
        file.found["NODES"] = file.numbers(size, after[1] if len(after) > 1 else "")
        return
    file.at = before
    flat = file.numbers(size, "int").astype(np.int64)
    at, counts = 0, []
    for _ in range(n):
        if at >= len(flat) or flat[at] < 0:
            raise wrong_file(file.path, "CELLS has not as many cells as it says", REMEDY)
        counts.append(at)
        at += int(flat[at]) + 1
    heads = np.array(counts, np.int64)
    file.found["ENDS"], file.found["NODES"] = np.cumsum(flat[heads]), np.delete(flat[:at], heads)
    if at != len(flat):
        raise wrong_file(file.path, "CELLS has not as many numbers as it says", REMEDY)


def _cell_types(file: LegacyFile, words: list[str]) -> None:
    file.found["TYPES"] = file.numbers(file.whole(words, 1), "int").astype(np.int64)


def _dimensions(file: LegacyFile, words: list[str]) -> None:
    file.found["DIMENSIONS"] = np.array([file.whole(words, k) for k in (1, 2, 3)])


def _three(file: LegacyFile, words: list[str]) -> None:
    """Three numbers in the line itself, of ORIGIN and SPACING."""
    name = "SPACING" if words[0].upper() == "ASPECT_RATIO" else words[0].upper()
    file.found[name] = numbers_of_text(file.path, " ".join(words[1:]).encode(), file.line, REMEDY)


def _axis(file: LegacyFile, words: list[str]) -> None:
    file.found[words[0].upper()] = file.numbers(file.whole(words, 1), words[2] if len(words) > 2 else "")


def _field(file: LegacyFile, words: list[str]) -> None:
    """Read arrays that belong to the whole file, such as a time, in order to find what follows."""
    for _ in range(file.whole(words, 2)):
        array = file.words()
        if array[:1] == ["METADATA"]:
            _metadata(file, array)
            array = file.words()
        if len(array) < 4 or array[3].lower() not in NUMBERS:
            raise wrong_file(file.path, "FIELD holds an array that is not of numbers", "Export the mesh without such data.")
        file.numbers(file.whole(array, 1) * file.whole(array, 2), array[3])


def _metadata(file: LegacyFile, _words: list[str]) -> None:
    """Read names of components, up to an empty line."""
    end = file.content.find(b"\n\n", file.at)
    file.at = len(file.content) if end < 0 else end + 2


SECTIONS: dict[str, Callable[[LegacyFile, list[str]], None]] = {
    "POINTS": _points, "CELLS": _cells, "CELL_TYPES": _cell_types, "DIMENSIONS": _dimensions, "ORIGIN": _three, "SPACING": _three,
    "ASPECT_RATIO": _three, "X_COORDINATES": _axis, "Y_COORDINATES": _axis, "Z_COORDINATES": _axis, "FIELD": _field,
    "METADATA": _metadata,
}  # fmt: skip
"""Sections that describe a grid."""


def _needed(file: LegacyFile, *names: str) -> list[np.ndarray]:
    missing = [name for name in names if name not in file.found]
    if missing:
        raise wrong_file(file.path, f"it has no {' and no '.join(missing)}", REMEDY)
    return [file.found[name] for name in names]


def _unstructured(file: LegacyFile) -> MeshContents:
    if "NODES" not in file.found:
        raise wrong_file(file.path, "it has no CELLS", REMEDY)
    points, types, ends, nodes = _needed(file, "POINTS", "TYPES", "ENDS", "NODES")
    return MeshContents(points.astype(float), cells_by_type(file.path, types, ends.astype(np.int64), nodes.astype(np.int64)), [])


def _structured(file: LegacyFile, grid: str) -> MeshContents:
    (dimensions,) = _needed(file, "DIMENSIONS")
    counts = tuple(dimensions.tolist())
    if grid == "STRUCTURED_GRID":
        (points,) = _needed(file, "POINTS")
    else:
        points = _product(_axes(file, grid, counts))
    if len(points) != counts[0] * counts[1] * counts[2]:
        raise wrong_file(file.path, "DIMENSIONS says another number of points than there are", REMEDY)
    return MeshContents(points.astype(float), grid_cells(file.path, counts), [])


def _axes(file: LegacyFile, grid: str, counts: tuple[int, ...]) -> list[np.ndarray]:
    """Coordinates along x, y and z."""
    if grid == "RECTILINEAR_GRID":
        return _needed(file, "X_COORDINATES", "Y_COORDINATES", "Z_COORDINATES")
    origin, spacing = _needed(file, "ORIGIN", "SPACING")
    if len(origin) != 3 or len(spacing) != 3:
        raise wrong_file(file.path, "ORIGIN and SPACING have three numbers each", REMEDY)
    return [start + step * np.arange(n) for start, step, n in zip(origin, spacing, counts, strict=True)]


def _product(axes: list[np.ndarray]) -> np.ndarray:
    """Points of a grid, x fastest."""
    z, y, x = np.meshgrid(axes[2], axes[1], axes[0], indexing="ij")
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()])
