"""Files of VTK's format in XML with an unstructured grid, .vtu: arrays as text, in base64 or behind the XML, compressed or not."""

from __future__ import annotations

import base64
import binascii
import lzma
import re
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

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
from preprocessing.foreign_files.vtk_legacy import REMEDY, cells_by_type, hidden
from toolkit.foundation.files.safe_files import read_whole

RAW = re.compile(rb"<AppendedData\s[^>]*encoding\s*=\s*[\"']raw[\"'][^>]*>\s*_", re.DOTALL)
NUMBERS = {f"{name}{bits}": f"{code}{bits // 8}" for name, code in (("Int", "i"), ("UInt", "u")) for bits in (8, 16, 32, 64)}
NUMBERS |= {"Float32": "f4", "Float64": "f8"}
"""Type of numbers in VTK -> that in NumPy."""
COMPRESSORS: dict[str, Callable[[bytes], bytes]] = {
    "vtkZLibDataCompressor": zlib.decompress,
    "vtkLZMADataCompressor": lzma.decompress,
}


class XmlFile(NamedTuple):
    """VTK file in XML: its XML, and the bytes behind it."""

    path: Path
    root: ElementTree.Element
    appended: bytes
    raw: bool  # whether these bytes are the numbers themselves, not in base64

    @property
    def order(self) -> str:
        """Order of bytes in words of NumPy."""
        return ">" if self.root.get("byte_order") == "BigEndian" else "<"

    @property
    def header(self) -> np.dtype:
        """Type of the counts before every array."""
        return np.dtype(f"{self.order}u{8 if self.root.get('header_type') == 'UInt64' else 4}")


def xml_vtk(path: Path, leave_out: frozenset[str]) -> MeshContents:
    """Points and cells of all pieces of a .vtu file.

    Raises
    ------
    InputError
        It holds no unstructured grid, is packed in a way that is not known or is not whole; or a cell is of a type that is no element here.
    """
    refuse_leave_out(path, leave_out, "VTK names nothing that could be")
    file = _opened(path)
    pieces = file.root.findall("UnstructuredGrid/Piece")
    if file.root.tag != "VTKFile" or file.root.get("type") != "UnstructuredGrid" or not pieces:
        raise wrong_file(path, "it holds no UnstructuredGrid with a Piece", "Export the elements of the body as .vtu or .vtk.")
    points: list[np.ndarray] = []
    cells: Elements = []
    for piece in pieces:
        first = sum(len(each) for each in points)
        points.append(_points(file, piece))
        cells.extend((kind, first + nodes) for kind, nodes in _cells(file, piece))
    return MeshContents(np.concatenate(points), cells, [])


def _opened(path: Path) -> XmlFile:
    """XML of a file, from which numbers that are no XML are cut out."""
    content = read_whole(path, LARGEST_FILE)
    raw = RAW.search(content)
    end = content.rfind(b"</AppendedData>") if raw else -1
    if raw and end < raw.end():
        raise wrong_file(path, "AppendedData has no end, so that the file is not whole", REMEDY)
    try:
        root = ElementTree.fromstring(content[: raw.end()] + content[end:] if raw else content)
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise wrong_file(path, "it is no XML, or not whole", REMEDY) from error
    if raw:
        return XmlFile(path, root, content[raw.end() : end], True)
    return XmlFile(path, root, _unbroken(root.findtext("AppendedData")).removeprefix(b"_"), False)


def _unbroken(text: str | None) -> bytes:
    """Text without blanks and ends of lines."""
    return "".join((text or "").split()).encode()


def _count(file: XmlFile, piece: ElementTree.Element, name: str) -> int:
    text = piece.get(name, "")
    if not text.isascii() or not text.isdigit() or len(text) > 15:
        raise wrong_file(file.path, f"a Piece has no {name}", REMEDY)
    return int(text)


def _points(file: XmlFile, piece: ElementTree.Element) -> np.ndarray:
    """Places of the points of a piece, (n, 3)."""
    array = piece.find("Points/DataArray")
    n = _count(file, piece, "NumberOfPoints")
    if array is None or array.get("NumberOfComponents") != "3":
        raise wrong_file(file.path, "a Piece has no Points with three components", REMEDY)
    return _numbers(file, array, 3 * n).astype(float).reshape(-1, 3)


def _cells(file: XmlFile, piece: ElementTree.Element) -> Elements:
    """Elements of a piece by kind."""
    arrays = {array.get("Name"): array for array in piece.findall("Cells/DataArray")}
    missing = [name for name in ("connectivity", "offsets", "types") if name not in arrays]
    if missing:
        raise wrong_file(file.path, f"the Cells of a Piece have no {' and no '.join(missing)}", REMEDY)
    n = _count(file, piece, "NumberOfCells")
    types, ends = (whole_numbers(file.path, _numbers(file, arrays[name], n), REMEDY) for name in ("types", "offsets"))
    nodes = whole_numbers(file.path, _numbers(file, arrays["connectivity"], int(ends[-1]) if n else 0), REMEDY)
    for array in piece.findall("CellData/DataArray"):
        if array.get("Name") == "vtkGhostType" and np.any(_numbers(file, array, n)):
            raise hidden(file.path)
    own = cells_by_type(file.path, types, ends, nodes)
    n_points = _count(file, piece, "NumberOfPoints")
    if any(np.any((each < 0) | (each >= n_points)) for _, each in own):
        raise wrong_file(file.path, "a cell has a node that its Piece does not hold", REMEDY)
    return own


def _numbers(file: XmlFile, array: ElementTree.Element, n: int) -> np.ndarray:
    """The n numbers of an array."""
    kind, form = array.get("type", ""), array.get("format", "ascii")
    if kind not in NUMBERS or form not in ("ascii", "binary", "appended"):
        raise wrong_file(file.path, "a DataArray is of a type or format that VTK does not have", REMEDY)
    if form == "ascii":
        found = numbers_of_text(file.path, (array.text or "").encode(), 0, REMEDY)
    else:
        dtype = np.dtype(file.order + NUMBERS[kind])
        content = _bytes(file, array, form)
        found = np.frombuffer(content[: len(content) // dtype.itemsize * dtype.itemsize], dtype)
    if len(found) != n:
        raise wrong_file(file.path, "a DataArray has more or fewer numbers than its Piece says", REMEDY)
    return found.astype(found.dtype.newbyteorder("="))


def _bytes(file: XmlFile, array: ElementTree.Element, form: str) -> bytes:
    """The numbers of an array as bytes."""
    if form == "binary":
        source, raw = _unbroken(array.text), False
    else:
        source, raw = file.appended[_offset(file, array) :], file.raw
    compressor = file.root.get("compressor")
    if compressor is None:
        size = int(_head(file, source, raw, 1)[0])
        return _part(file, source, raw, file.header.itemsize, size)
    if compressor not in COMPRESSORS:
        raise wrong_file(
            file.path,
            "its arrays are compressed otherwise than by ZLib or LZMA",
            "Export it again with ZLib, or without compression.",
        )
    return _decompressed(file, source, raw, COMPRESSORS[compressor])


def _offset(file: XmlFile, array: ElementTree.Element) -> int:
    text = array.get("offset", "")
    if not text.isascii() or not text.isdigit() or int(text[:18]) >= len(file.appended):
        raise wrong_file(file.path, "a DataArray has no offset within AppendedData", REMEDY)
    return int(text[:18])


def _decompressed(file: XmlFile, source: bytes, raw: bool, decompress: Callable[[bytes], bytes]) -> bytes:
    """Blocks one behind the other; before them stand their number, two sizes, and their sizes as they are packed."""
    n = int(_head(file, source, raw, 1)[0])
    sizes = _head(file, source, raw, 3 + n)[3:].astype(np.int64)
    length = file.header.itemsize * (3 + n)
    start = length if raw else -(-length // 3) * 4  # the head is in base64 by itself
    packed = _part(file, source[start:], raw, 0, int(sizes.sum()))
    ends = np.cumsum(sizes).tolist()
    try:
        return b"".join(decompress(packed[end - size : end]) for end, size in zip(ends, sizes.tolist(), strict=True))
    except (zlib.error, lzma.LZMAError, EOFError) as error:
        raise wrong_file(file.path, "a compressed array is damaged", REMEDY) from error


def _head(file: XmlFile, source: bytes, raw: bool, n: int) -> np.ndarray:
    """The first n counts of an array."""
    return np.frombuffer(_part(file, source, raw, 0, n * file.header.itemsize), file.header)


def _part(file: XmlFile, source: bytes, raw: bool, start: int, size: int) -> bytes:
    """So many bytes behind the first `start` ones of a source that is raw, or in base64."""
    if size > len(source) or size < 0:
        raise wrong_file(file.path, "an array claims more bytes than there are", REMEDY)
    if raw:
        found = source[start : start + size]
    else:
        try:
            found = base64.b64decode(source[: -(-(start + size) // 3) * 4])[start : start + size]
        except (binascii.Error, ValueError) as error:
            raise wrong_file(file.path, "an array is not in base64", REMEDY) from error
    if len(found) != size:
        raise wrong_file(file.path, "an array claims more bytes than there are", REMEDY)
    return found
