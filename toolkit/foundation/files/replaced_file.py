"""Files in one stroke: written under a temporary name, brought to the disk, then renamed; what fails leaves the old file or none."""

from __future__ import annotations

import errno
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from toolkit.foundation.errors import InputError


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A temporary file beside `path` to write to; it takes the name of `path` if nothing was raised, and vanishes otherwise.

    A link stays a link, to the new content, and a file that is replaced hands on its permissions. What is no file (a folder, a device,
    a pipe) is never replaced. A process that is killed leaves the temporary file behind (NAME....tmp.h5). Nothing reads such files
    and nothing deletes them, since another process might be writing to them: that is left to the user.

    Raises
    ------
    InputError
        The place cannot be written to, or is full.
    """
    try:
        with in_one_stroke(path) as temporary:
            yield temporary
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be written ({error.strerror or error}). Give a writable place.") from error


def write_whole(path: Path, content: bytes) -> None:
    """Write a file that was built in memory, so that a full disk meets no library in the middle of its work; raises as `replaced`."""
    with replaced(path) as temporary:
        temporary.write_bytes(content)


@contextmanager
def in_one_stroke(path: Path) -> Iterator[Path]:
    """Temporary file as `replaced` gives it, with the errors of the system."""
    place = Path(os.path.realpath(path))
    mode = _mode_of(place)
    temporary = place.with_name(f"{place.stem}{secrets.token_hex(4)}.tmp{place.suffix}")
    os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    try:
        yield temporary
        if mode is not None:
            temporary.chmod(mode)
        with temporary.open("rb+") as file:
            os.fsync(file.fileno())
        temporary.replace(place)
    finally:
        temporary.unlink(missing_ok=True)


def _mode_of(place: Path) -> int | None:
    """Permissions of the file that is there; None if there is none."""
    try:
        found = place.stat().st_mode
    except FileNotFoundError:
        return None
    if not stat.S_ISREG(found):
        raise OSError(errno.EINVAL, "it is not a regular file")
    return stat.S_IMODE(found)
