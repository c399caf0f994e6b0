"""Arrays of numbers from .npy, .npz or text; nothing is unpacked or allocated that the file does not hold."""

from __future__ import annotations

import re
import zipfile
from io import BytesIO
from math import prod
from pathlib import Path

import numpy as np

from preprocessing.foreign_files.matrices.number_lines import number_lines, plain_text

UNPACKED, UNPACKED_PER_BYTE = 2**28, 50
"""Most bytes that an archive may unpack to: the first, and this many for each of its bytes; numbers of places pack ten to one."""
LONGEST_HEADER = 10_000
"""Bytes of the text in a .npy file that says what it holds."""


WIDEST = 10_000
"""Most fields of a line of a text; a table of nodes has three."""
NAMES = re.compile(rb"\s*\"?x\"?\s*,\s*\"?y\"?\s*(?:,\s*\"?z\"?\s*)?", re.IGNORECASE)
"""The only first line of words whose meaning is plain: the names of the coordinates."""


def number_table(path: str) -> np.ndarray:
    """The array of a .npy file, the only one of a .npz archive, or the numbers of a text with commas."""
    file = Path(path)
    if file.suffix == ".npy":
        return array_of(file.read_bytes())
    if file.suffix == ".npz":
        return _only_one(archive(file))
    return table_of(file.read_bytes())


def table_of(content: bytes) -> np.ndarray:
    """The numbers of a text with a comma between two of them, or blanks where there is no comma at all.

    What follows # is a comment, and the first line may name the coordinates.

    Raises
    ------
    ValueError
        It names the first line that is none of numbers.
    """
    text = re.sub(rb"#[^\n]*", b"", plain_text(content))
    first, _, rest = text.partition(b"\n")
    body, before = (rest, 1) if NAMES.fullmatch(first) else (text, 0)
    return number_lines(body, range(1, WIDEST), "," if b"," in body else None, before)


def _only_one(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """The array of an archive that holds no other, so that none is taken by chance."""
    if len(arrays) > 1:
        raise ValueError(f"it holds {len(arrays)} arrays, and it is not clear which of them is meant; keep one")
    return next(iter(arrays.values()))


def archive(path: Path) -> dict[str, np.ndarray]:
    """All arrays of a .npz file; raises ValueError if there is none, or they are larger than the file can mean."""
    with zipfile.ZipFile(path) as packed:
        members = packed.infolist()
        unpacked, most = sum(each.file_size for each in members), UNPACKED + UNPACKED_PER_BYTE * path.stat().st_size
        if unpacked > most:
            raise ValueError(f"its {path.stat().st_size} bytes unpack to {unpacked}, and no more than {most} are meant")
        found = {each.filename.removesuffix(".npy"): array_of(packed.read(each)) for each in members}
    if not found:
        raise ValueError("it holds no array")
    return found


def array_of(content: bytes) -> np.ndarray:
    """The array of a .npy file's content; raises ValueError if it claims another size than it has, or holds objects."""
    stream = BytesIO(content)
    version = np.lib.format.read_magic(stream)
    read_header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read_header(stream, max_header_size=LONGEST_HEADER)
    claimed, held = prod(shape) * dtype.itemsize, len(content) - stream.tell()
    if dtype.hasobject or min(shape, default=0) < 0 or claimed != held:
        raise ValueError(f"it claims an array {shape} of {dtype.itemsize} bytes each, and holds {held} bytes")
    stream.seek(0)
    return np.lib.format.read_array(stream, allow_pickle=False, max_header_size=LONGEST_HEADER)
