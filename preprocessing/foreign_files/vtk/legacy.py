"""Files of VTK's simple format, .vtk, as text and binary."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from preprocessing.foreign_files.bounds import LARGEST_FILE
from preprocessing.foreign_files.contents import MeshContents
from preprocessing.foreign_files.meshes.numbers_of_text import numbers_of_text, whole_numbers
from preprocessing.foreign_files.meshes.wrong_file import refuse_leave_out, wrong_file
from preprocessing.foreign_files.vtk.cells import REMEDY, cells_by_type, grid_cells, hidden
from toolkit.foundation.files.regular_file import read_whole

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
