"""HDF5 as the program uses it: written with checksums, and read as if an enemy had written it.

The library is never given a file to read in this process: with the right checksums a few changed bytes end it, or worse. `hdf5_source`
reads what this program writes, in Python, and refuses the rest of the format; `plain_hdf5` brings files of other programs into that form.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.files.hdf5_objects import FORMAT, MOST_BYTES, SIGNATURE, SQUEEZED, File, Group
from toolkit.foundation.files.hdf5_source import OtherForm, Source
from toolkit.foundation.files.hdf5_storage import Array
from toolkit.foundation.files.plain_hdf5 import in_own_form
from toolkit.foundation.files.safe_files import opened, write_whole

if TYPE_CHECKING:
    import h5py

__all__ = ["SIGNATURE", "Content", "reading", "schema_of", "text_of", "write_array", "writing"]

SMALL, SMALL_SCALAR = 1024, 60_000
"""Bytes of an array, and of a single text, up to which it is kept within those structures and needs no checksum of its own."""

_UNREADABLE = (OSError, LookupError, RuntimeError, ValueError, TypeError, AttributeError, OverflowError, MemoryError)
"""Errors that the system, numpy and the parsers raise on damaged content."""


@contextmanager
def writing(path: Path) -> Iterator[h5py.File]:
    """New HDF5 file, built in memory and put in its place as a whole if nothing was raised.

    HDF5 ends the process where the disk is full.

    Raises
    ------
    InputError
        The place cannot be written to, or is full.
    """
    import h5py

    content = BytesIO()
    with h5py.File(content, "w", libver=FORMAT) as file:
        yield file
    write_whole(path, content.getvalue())


def write_array(group: h5py.Group, name: str, values: Any) -> None:
    """Write numbers or texts so that a flipped bit is noticed, except in a single text of more than 60 kB."""
    import h5py

    single = np.ndim(values) == 0
    if np.asarray(values).nbytes <= (SMALL_SCALAR if single else SMALL):
        compact = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        compact.set_layout(h5py.h5d.COMPACT)
        group.create_dataset(name, data=values, dcpl=compact)
    else:
        options = {} if single else {"compression": "gzip", "shuffle": True, "fletcher32": True}
        group.create_dataset(name, data=values, **options)


class Content:
    """Content of an open file, as far as it can be believed.

    All arrays together can be no larger than the bytes of the file, unpacked; only hard links are followed, since others lead to
    other files or in circles. Every method raises ValueError for what is missing or cannot be.
    """

    def __init__(self, file: File, size: int) -> None:
        self._file = file
        self._left = min(SQUEEZED * size, MOST_BYTES)
        self.plain = False
        """Whether the file was plain HDF5 of another program, without checksums."""
        self.bytes_read: dict[str, int] = {}
        """Group -> bytes of its arrays that were read, as they are stored in the file."""

    def group(self, name: str) -> list[str]:
        """Names of all that is in a group."""
        return list(self._group(name).links)

    def has(self, name: str) -> bool:
        """Whether there is something of that name."""
        above, _, last = name.rpartition("/")
        try:
            return last in self._group(above).links
        except LookupError:
            return False

    def stored_bytes(self, name: str) -> int:
        """Bytes that all arrays below a group take in the file, each counted once."""
        found: dict[int, Array | Group] = {}
        waiting = [self._found(name)]
        while waiting:
            each = waiting.pop()
            if id(each) not in found and isinstance(each, Group):
                waiting += [self._file.object(link.place) for link in each.links.values() if link.place is not None]
            found[id(each)] = each
        return sum(each.stored_bytes for each in found.values() if isinstance(each, Array))

    def array(self, name: str) -> np.ndarray:
        """Numbers as int64 or float64, or byte strings."""
        try:
            values = self._read(name)
        except ValueError as error:
            raise ValueError(f"{name} cannot be read: {error}") from error
        kind = values.dtype.kind
        return values if kind == "S" else values.astype(float if kind == "f" else np.int64, copy=False)

    def attributes(self, name: str = "/") -> dict[str, str | int | float]:
        """Attributes of a group, each of which is one number or one text."""
        owner = self._group(name)
        return {key: owner.attribute(key) for key in owner.attributes}

    def in_order(self, name: str) -> bool:
        """Whether the file keeps the order in which the attributes of a group were made."""
        return self._group(name).in_order

    def _read(self, name: str) -> np.ndarray:
        """Array of that name, if what is claimed for all arrays can be in the file."""
        data = self._found(name)
        if not isinstance(data, Array):
            raise ValueError("the file has something else of that name")
        self._left -= data.claimed
        if self._left < 0:
            raise ValueError(f"it claims {data.claimed} bytes, which are not in the file")
        values = data.read()
        group = name.split("/")[0]
        self.bytes_read[group] = self.bytes_read.get(group, 0) + data.stored_bytes
        return values

    def _group(self, name: str) -> Group:
        found = self._found(name)
        if not isinstance(found, Group):
            raise _Lacking(f"it lacks the group {name}, or has an array of that name")
        return found

    def _found(self, name: str) -> Group | Array:
        found: Group | Array = self._file
        for part in filter(None, name.split("/")):
            link = found.links.get(part) if isinstance(found, Group) else None
            if link is None or link.place is None:
                raise _Lacking(f"it lacks {name}")
            found = self._file.object(link.place)
        return found


class _Lacking(ValueError, LookupError):
    """There is nothing of that name, or something that is not followed."""


@contextmanager
def reading(path: Path, damaged: Callable[[str], ToolkitError], foreign: bool = False) -> Iterator[Content]:
    """Content of a file; whatever it makes the libraries raise becomes the error that `damaged` makes of its reason.

    With `foreign` the file may be plain HDF5 of another program.
    """
    try:
        with _opened(path) if not foreign else _opened_of_any_program(path) as content:
            yield content
    except ToolkitError:
        raise
    except _UNREADABLE as error:
        raise damaged(str(error)) from error


def schema_of(path: Path) -> str | None:
    """Schema of one of the program's HDF5 files, by its attribute `schema`; None if it cannot be read as one."""
    return text_of(path, "schema")


def text_of(path: Path, attribute: str) -> str | None:
    """Text of one attribute of a file, also of plain HDF5 of another program; None if it has none, or cannot be read."""
    try:
        with _opened_of_any_program(path, head=True) as content:
            return str(content.attributes()[attribute])
    except _UNREADABLE:
        return None


@contextmanager
def _opened(path: Path) -> Iterator[Content]:
    """Content of a regular file: a pipe would be waited for."""
    with opened(path) as file:
        size = os.fstat(file.fileno()).st_size
        yield Content(File(Source(file, size)), size)


@contextmanager
def _opened_of_any_program(path: Path, head: bool = False) -> Iterator[Content]:
    """Content of a file, also of plain HDF5 of another program, which its root gives away.

    With `head` it is that of the root's attributes alone.
    """
    with ExitStack() as stack:
        try:
            content = stack.enter_context(_opened(path))
            content.attributes()
        except OtherForm:
            own = in_own_form(path, head)
            content = Content(File(Source(BytesIO(own), len(own))), len(own))
            content.plain = True
        yield content
