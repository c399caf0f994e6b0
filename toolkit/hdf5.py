"""HDF5 as the program uses it: written with checksums, and read as if an enemy had written it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from toolkit.errors import ToolkitError
from toolkit.replaced_file import write_whole

FORMAT = ("v110", "v110")
"""Version of HDF5's own structures: from this one on they carry checksums, so that a flipped bit is noticed and not followed."""

SIGNATURE, OLDEST = b"\x89HDF\r\n\x1a\n", 3
"""First bytes of every HDF5 file, and behind them the number of its format, of which this is the first that has checksums."""

SMALL, SMALL_SCALAR = 1024, 60_000
"""Bytes of an array, and of a single text, up to which it is kept within those structures and needs no checksum of its own."""

SQUEEZED = 1100
"""Most that HDF5's compression makes of a byte, with a little to spare; a file that claims more was never written."""

FILTERS = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32}

_UNREADABLE = (OSError, LookupError, RuntimeError, ValueError, TypeError, AttributeError, OverflowError, MemoryError)
"""What h5py, numpy and the parsers raise on damaged content."""


@contextmanager
def writing(path: Path) -> Iterator[h5py.File]:
    """A new file, built in memory and put in its place as a whole if nothing was raised: HDF5 ends the process where the disk is full.

    Raises
    ------
    InputError
        The place cannot be written to, or is full.
    """
    content = BytesIO()
    with h5py.File(content, "w", libver=FORMAT) as file:
        yield file
    write_whole(path, content.getvalue())


def write_array(group: h5py.Group, name: str, values: Any) -> None:
    """Write numbers or texts, all of them (but a single text of more than 60 kB) so that a flipped bit is noticed."""
    single = np.ndim(values) == 0
    if np.asarray(values).nbytes <= (SMALL_SCALAR if single else SMALL):
        compact = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        compact.set_layout(h5py.h5d.COMPACT)
        group.create_dataset(name, data=values, dcpl=compact)
    else:
        options = {} if single else {"compression": "gzip", "shuffle": True, "fletcher32": True}
        group.create_dataset(name, data=values, **options)


class Content:
    """What an open file holds, as far as it can be believed.

    All arrays together can be no larger than the bytes of the file, unpacked; only hard links are followed, since others lead to
    other files or in circles. Every method raises ValueError for what is missing or cannot be.
    """

    def __init__(self, file: h5py.File, size: int) -> None:
        self._file = file
        self._left = SQUEEZED * size
        self.bytes_read: dict[str, int] = {}
        """Group -> bytes of its arrays that were read, as they are stored in the file."""

    def group(self, name: str) -> list[str]:
        """Names in a group."""
        return [_readable(key) for key in self._found(name, h5py.Group)]

    def has(self, name: str) -> bool:
        """Whether there is something of that name."""
        return self._file.get(name, getlink=True) is not None

    def stored_bytes(self, name: str) -> int:
        """Bytes that all arrays below a group take in the file."""
        found = self._found(name, (h5py.Group, h5py.Dataset))
        if isinstance(found, h5py.Dataset):
            return found.id.get_storage_size()
        return sum(self.stored_bytes(f"{name}/{key}") for key in self.group(name))

    def array(self, name: str) -> np.ndarray:
        """Numbers as int64 or float64, or byte strings."""
        data = self._found(name, h5py.Dataset)
        kind, n = data.dtype.kind, data.dtype.itemsize
        if data.shape is None or kind not in "fiuS" or (kind != "S" and n > 8):
            raise ValueError(f"{name} is {data.dtype} instead of numbers")
        self._pay(name, data)
        values = np.asarray(data[()])
        group = name.split("/")[0]
        self.bytes_read[group] = self.bytes_read.get(group, 0) + data.id.get_storage_size()
        return values if kind == "S" else values.astype(float if kind == "f" else np.int64, copy=False)

    def attributes(self, name: str = "/") -> dict[str, str | int | float]:
        """All attributes, each of which is one number or one text."""
        owner = self._found(name, h5py.Group)
        return {_readable(key): _scalar(owner, key) for key in owner.attrs}

    def _found(self, name: str, kind: type | tuple[type, ...]) -> Any:
        found: Any = self._file
        for part in filter(None, name.split("/")):
            if not isinstance(found, h5py.Group) or not isinstance(found.get(part, getlink=True), h5py.HardLink):
                raise ValueError(f"it lacks {name}")
            found = found[part]
        if not isinstance(found, kind):
            raise ValueError(f"it lacks {name}, or has something else of that name")
        return found

    def _pay(self, name: str, data: h5py.Dataset) -> None:
        """Refuse what is not in the file, or is packed in a way that unpacks without limit."""
        settings = data.id.get_create_plist()
        filters = [settings.get_filter(i)[0] for i in range(settings.get_nfilters())]
        piece = data.dtype.itemsize * int(np.prod(data.chunks or (), dtype=object))
        claimed = max(data.dtype.itemsize * int(np.prod(data.shape, dtype=object)), piece)
        self._left -= claimed
        elsewhere = data.is_virtual or data.external or not set(filters) <= FILTERS or len(set(filters)) < len(filters)
        if elsewhere or self._left < 0:
            raise ValueError(f"{name} claims {claimed} bytes, which are not in the file")


@contextmanager
def reading(path: Path, damaged: Callable[[str], ToolkitError]) -> Iterator[Content]:
    """The content of a file; whatever it makes the libraries raise becomes the error that `damaged` makes of its reason."""
    try:
        with _opened(path) as file:
            yield Content(file, path.stat().st_size)
    except ToolkitError:
        raise
    except _UNREADABLE as error:
        raise damaged(str(error)) from error


def schema_of(path: Path) -> str | None:
    """Which of the program's HDF5 files it is, by its attribute `schema`; None if it cannot be read as one."""
    return text_of(path, "schema")


def text_of(path: Path, attribute: str) -> str | None:
    """One attribute of a file; None if it has none, or cannot be read as one of the program's."""
    try:
        with _opened(path) as file:
            return str(_scalar(file, attribute))
    except _UNREADABLE:
        return None


def _opened(path: Path) -> h5py.File:
    """The file, unless it is of HDF5's older formats: damage there is not noticed but followed, for ever if it leads in a circle."""
    with path.open("rb") as file:
        start = file.read(len(SIGNATURE) + 1)
    if start[:-1] != SIGNATURE:
        raise ValueError("it is no HDF5 file")
    if start[-1] < OLDEST:
        raise ValueError("it was written by another program or an old version of this one, in a format without checksums")
    return h5py.File(path, "r")


def _scalar(owner: h5py.Group, key: str) -> str | int | float:
    """A number, or a text of fixed length: the place where HDF5 keeps those of variable length has no checksum."""
    stored = owner.attrs.get_id(key)
    if stored.shape != () or stored.dtype.kind not in "fiuS" or (stored.dtype.kind != "S" and stored.dtype.itemsize > 8):
        raise ValueError(f"the attribute {key} is neither a number nor a text of fixed length")
    value = owner.attrs[key]
    return value.decode() if isinstance(value, bytes) else value.item()


def _readable(text: str) -> str:
    """The text itself, if it was written as UTF-8."""
    text.encode()
    return text
