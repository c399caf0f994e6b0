"""Plain HDF5 of other programs (h5py as it is by default, MATLAB, Julia), brought into the form that this program writes and reads.

The library reads them, in a process of its own: a file that makes it crash, or claims more than it holds, ends that process alone. What
comes back is read as if an enemy had written it, as every file is. Such files have no checksums: a flipped bit is not noticed.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from toolkit.foundation.files.hdf5_objects import FORMAT, MOST_BYTES, SQUEEZED
from toolkit.foundation.files.safe_files import size_of
from toolkit.foundation.processes import ONE_THREAD, command, environment, limit_process, memory_of_machine, refuse_namesakes

if TYPE_CHECKING:
    import h5py

LARGEST_FILE = 2 * 10**9
"""Bytes of such a file at most."""
MEMORY, MEMORY_PER_BYTE = 2**30, 50
"""Bytes that the process may take, and for each byte of the file: gzip makes some ten of one."""
SECONDS, SECONDS_PER_BYTE, PATIENCE = 30, 1e-6, 3
"""Seconds of processor time that it may take, and how many times longer it is waited for."""
MOST_OBJECTS, DEEPEST = 100_000, 8
"""Groups and arrays of a file, and how deep they lie in each other: a reduced model has a hundred and three."""
NO_PLUGINS = {"HDF5_PLUGIN_PRELOAD": "::"}
"""The library loads no code for a filter that it does not have."""
CHILD = "from toolkit.foundation.files.plain_hdf5 import main; main(*sys.argv[1:])"
WELL, REFUSED, TOO_LARGE, ENDLESS = 0, 3, 4, 5
"""Exit codes of the process, and the one that stands for none."""


def in_own_form(path: Path, head: bool) -> bytes:
    """Content of a file as this program would have written it; with `head` the attributes of its root alone.

    Raises
    ------
    ValueError
        Its content is of a kind that no file of this program has, or the library cannot read it.
    """
    size, state = size_of(path), path.stat()
    if size > LARGEST_FILE:
        raise ValueError(f"it is HDF5 of another program, of which at most {LARGEST_FILE} bytes are read")
    code, content = _kept(path.resolve(), head, size, (state.st_ino, state.st_mtime_ns))
    if code == WELL:
        return content
    reasons = {
        REFUSED: content.decode(),
        TOO_LARGE: "it claims more than it can hold",
        ENDLESS: "the library comes to no end with it",
    }
    raise ValueError(f"it is HDF5 of another program, and {reasons.get(code, 'the library cannot read it either')}")


@lru_cache(maxsize=4)
def _kept(path: Path, head: bool, size: int, state: tuple[int, ...]) -> tuple[int, bytes]:
    """Answer of the process, kept for as long as the file is as it was."""
    return _apart(path, head, size)


def _apart(path: Path, head: bool, size: int) -> tuple[int, bytes]:
    """Answer of `answer` from a process of its own that may take memory and time in proportion to the size of the file."""
    refuse_namesakes()
    memory, seconds = MEMORY + MEMORY_PER_BYTE * size, int(SECONDS + SECONDS_PER_BYTE * size)
    arguments = (str(path), "head" if head else "whole", str(min(memory, memory_of_machine() or memory)), str(seconds))
    try:
        done = subprocess.run(
            command(CHILD, *arguments),
            env=environment() | ONE_THREAD | NO_PLUGINS,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=PATIENCE * seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return ENDLESS, b""
    return done.returncode, done.stdout


def main(path: str, part: str, memory: str, seconds: str) -> None:
    """Send the answer from the process of its own, within its limits."""
    limit_process(int(memory), int(seconds))
    code, content = answer(Path(path), part == "head")
    sys.stdout.buffer.write(content)
    sys.stdout.flush()
    raise SystemExit(code)


def answer(path: Path, head: bool) -> tuple[int, bytes]:
    """Code and content: the file in the form of this program, or why not; the library may raise anything else."""
    try:
        return WELL, _rewritten(path, head)
    except _Foreign as error:
        return REFUSED, str(error).encode()
    except MemoryError:
        return TOO_LARGE, b""


class _Foreign(Exception):
    """Error of a content that no file of this program has, in words that quote nothing of the file."""


@dataclass
class _Room:
    """Bytes and objects that may still be read."""

    bytes: int
    objects: int = MOST_OBJECTS

    def take(self, size: int) -> None:
        """Count one object of so many bytes."""
        self.bytes -= size
        self.objects -= 1
        if self.bytes < 0:
            raise _Foreign("it claims more than it can hold")
        if self.objects < 0:
            raise _Foreign(f"it has more than {MOST_OBJECTS} groups and arrays, or they lead in circles")


def _rewritten(path: Path, head: bool) -> bytes:
    import h5py

    content, room = BytesIO(), _Room(min(SQUEEZED * path.stat().st_size, MOST_BYTES))
    with h5py.File(path, "r", locking=False) as found, h5py.File(content, "w", libver=FORMAT) as own:
        _copy_attributes(found, own)
        if not head:
            _copy_content(found, own, room, 0)
    return content.getvalue()


def _copy_content(found: h5py.Group, own: h5py.Group, room: _Room, depth: int) -> None:
    """Copy all groups and arrays below a group.

    What lies in other files or is found by another name is left out, as it always is.
    """
    if depth > DEEPEST:
        raise _Foreign(f"its groups lie deeper in each other than {DEEPEST} times, or lead in circles")
    import h5py

    for name, each in _objects(found):
        if isinstance(each, h5py.Group):
            room.take(0)
            created = each.id.get_create_plist().get_attr_creation_order()
            below = own.create_group(name, track_order=bool(created))
            _copy_attributes(each, below)
            _copy_content(each, below, room, depth + 1)
        else:
            own.create_dataset(name, data=_values(each, room))


def _objects(group: h5py.Group) -> Iterator[tuple[str, Any]]:
    import h5py

    for name in group:
        if isinstance(group.get(name, getlink=True), h5py.HardLink) and not isinstance(each := group[name], h5py.Datatype):
            yield name, each


def _values(array: h5py.Dataset, room: _Room) -> np.ndarray:
    """The numbers or texts of an array."""
    import h5py

    if array.is_virtual or array.external:
        raise _Foreign("an array of it lies in other files; write all of it into one")
    if array.shape is None:
        raise _Foreign("an array of it has no shape; leave it out, or write one with a length of zero")
    room.take(array.size * array.dtype.itemsize)
    if h5py.check_string_dtype(array.dtype) is not None and array.dtype.kind == "O":
        return _texts(array, room)
    if array.dtype.kind == "b":
        return array[()].astype(np.int8)
    if not (array.dtype.kind in "iuS" or (array.dtype.kind == "f" and array.dtype.itemsize <= 8)):
        raise _Foreign("an array of it holds neither whole nor floating-point numbers of at most 8 bytes, nor texts")
    return array[()]


def _texts(array: h5py.Dataset, room: _Room) -> np.ndarray:
    """Texts of variable length, as texts of one length."""
    texts = np.array(array[()], object)
    room.take(texts.size * max((len(text) for text in texts.ravel()), default=1))
    return texts.astype(bytes)


def _copy_attributes(found: h5py.Group, own: h5py.Group) -> None:
    for name in found.attrs:
        own.attrs[name] = _attribute(found.attrs[name])


def _attribute(value: object) -> Any:
    """Attribute as this program would have written it: one number, or a text of fixed length."""
    import h5py

    if isinstance(value, h5py.Empty):
        value = b"" if value.dtype.kind in "SO" else value
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.ravel()[0]
    if isinstance(value, str):
        return np.bytes_(value.encode())
    if isinstance(value, bytes):
        return np.bytes_(value.rstrip(b"\0 "))
    if isinstance(value, (np.bool_, bool)):
        return int(value)
    if isinstance(value, (int, float, np.integer, np.floating)):
        return value
    raise _Foreign("an attribute of one of its groups is neither a number nor a text")
