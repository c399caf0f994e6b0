"""Files of others as bytes: regular ones and of bounded size, so that no pipe is waited for and no device is read without end."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path
from typing import BinaryIO

KINDS = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
    stat.S_IFDIR: "a folder",
}
"""Words for what a path may lead to besides a regular file."""
AT_ONCE = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
"""Flags under which opening never waits, should the file have become a pipe after it was looked at."""


def opened(path: Path) -> BinaryIO:
    """A regular file, open to be read.

    Raises
    ------
    OSError
        The system cannot open it, or it is something else than a regular file.
    """
    try:
        _refuse(os.stat(path).st_mode, path)  # some devices act when they are opened
        handle = os.open(path, os.O_RDONLY | AT_ONCE)
    except ValueError as error:  # a zero byte in the path
        raise OSError(errno.EINVAL, str(error), str(path)) from error
    try:
        _refuse(os.fstat(handle).st_mode, path)
    except OSError:
        os.close(handle)
        raise
    return os.fdopen(handle, "rb")


def size_of(path: Path) -> int:
    """Size of a regular file in bytes; raises as `opened`."""
    with opened(path) as file:
        return os.fstat(file.fileno()).st_size


def read_start(path: Path, most: int) -> bytes:
    """Bytes of the whole file, or its first `most` bytes; raises as `opened`."""
    with opened(path) as file:
        return file.read(most)


def read_whole(path: Path, most: int) -> bytes:
    """Bytes of the whole file.

    Raises
    ------
    OSError
        As `opened`; or the file has more than `most` bytes.
    """
    with opened(path) as file:
        size = os.fstat(file.fileno()).st_size
        content = file.read(size + 1) if size <= most else b""  # room for the most is more than a bounded process has
        if len(content) > size:  # it grew meanwhile
            content += file.read(most - size)
    if size > most or len(content) > most:
        raise OSError(errno.EFBIG, f"it has more than {most} bytes", str(path))
    return content


def _refuse(mode: int, path: Path) -> None:
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, f"it is {KINDS.get(stat.S_IFMT(mode), 'something else')}, not a regular file", str(path))
