"""A file that one run at a time works with: the lock is the system's, and ends with the process however that ends."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from toolkit.foundation.errors import InputError


class FileInUseError(InputError):
    """Error of a file that another run works with."""


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Lock for `path`, with which nobody else works meanwhile: an empty file beside it, NAME.lock, is locked.

    That file stays, and says nothing: the lock counts, and the system takes it away from a process that is killed. To delete the file
    at the end would give those who wait for it and those who come later locks of two different files.

    Raises
    ------
    FileInUseError
        Another run, of this process or another one, works with it.
    InputError
        The place cannot be written to, or its file system has no locks.
    """
    beside = path.with_name(f"{path.name}.lock")
    try:
        descriptor = os.open(beside, os.O_CREAT | os.O_RDWR, 0o666)
    except OSError as error:
        raise InputError(f"{str(beside)!r} cannot be written ({error.strerror or error}). Give a writable place.") from error
    try:
        _lock(descriptor, path)
        yield
    finally:
        os.close(descriptor)


def _lock(descriptor: int, path: Path) -> None:
    import fcntl

    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise FileInUseError(
            f"another run works with {str(path)!r}, and what both of them solve would be lost. Wait until it has ended, or give another "
            "folder with --output."
        ) from error
    except OSError as error:
        raise InputError(
            f"{str(path)!r} cannot be locked against other runs ({error.strerror or error}). Give a folder on another file system with "
            "--output."
        ) from error
