"""Files of others read within bounds, and own files written in one stroke and locked.

Files that the program has written into a folder: a list beside them tells what it may replace, and what to take away.

Whoever writes a set of files into a folder refuses before anything long what is there of these names and not in the list
(`refuse_foreign`), and lists the names when it begins to write (`list_own`): files of an earlier set that are not written again go.
If nothing comes of it, what was made for it goes too (`own_set`).
"""

from __future__ import annotations

import errno
import os
import re
import secrets
import stat
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from fnmatch import fnmatchcase
from itertools import islice
from pathlib import Path
from typing import BinaryIO

from toolkit.foundation.errors import InputError, meant

MOST_NAMES = 1000
"""Names of a folder that are looked at."""


def file_name(name: str) -> str:
    """Name of a file, unchanged if a file can have it.

    Raises
    ------
    ValueError
        No file of any system can have it.
    """
    if "\0" in name:
        raise ValueError("a file name cannot hold a zero byte; write the path of the file")
    return name


def meant_path(path: Path, error: OSError) -> str:
    """Part of a sentence with the probable name of the first missing part of a path; empty if nothing is like it or missing."""
    if not isinstance(error, FileNotFoundError):
        return ""
    missing = path
    while not missing.parent.is_dir():
        missing = missing.parent
    try:
        return meant(missing.name, [each.name for each in islice(missing.parent.iterdir(), MOST_NAMES)])
    except OSError:
        return ""


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


OWN = ".ffrf"
"""File in a folder that lists, by name, what the program has written there."""


def listed(folder: Path) -> Sequence[str]:
    """Names in the list of a folder; none where there is no list."""
    own = folder / OWN
    return own.read_text(encoding="utf-8", errors="replace").splitlines() if own.is_file() else []


def refuse_foreign(folder: Path, names: Collection[str]) -> None:
    """Refuse to write into a folder where something is that would be replaced, or be mixed with what is written.

    Parameters
    ----------
    names : names of what is to be written there, or patterns of them

    Raises
    ------
    InputError
        A file or folder of these names is not in the list.
    """
    known = set(listed(folder))
    found = (file for name in names for file in sorted(folder.glob(name)))
    if (there := next((file for file in found if file.name not in known), None)) is not None:
        raise InputError(f"{str(there)!r} is there, and ffrf has not written it. Give another folder, or move it away.")


def list_own(folder: Path, names: Collection[str], instead_of: Collection[str] = ()) -> None:
    """Add names to the list, and take files away that are in it by one of the patterns `instead_of` but not among these names.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    before = set(listed(folder))
    gone = {name for name in before - {*names} if any(fnmatchcase(name, pattern) for pattern in instead_of)}
    if gone or not before >= {*names}:
        write_whole(folder / OWN, "\n".join(sorted({*before, *names} - gone)).encode())
    for name in gone:
        (folder / name).unlink(missing_ok=True)


@contextmanager
def own_set(folder: Path, names: Collection[str], instead_of: Collection[str] = ()) -> Iterator[None]:
    """Make a folder, list the names, and write there; raises as `list_own`.

    What fails before its first file leaves nothing behind.
    """
    made = missing(folder)
    folder.mkdir(parents=True, exist_ok=True)
    try:
        list_own(folder, names, instead_of)
        yield
    finally:
        leave_nothing(folder, made)


def missing(folder: Path) -> list[Path]:
    """Folder and the folders that it lies in, as far as they are not there, innermost first."""
    return [each for each in (folder, *folder.parents) if not each.exists()]


def leave_nothing(folder: Path, made: Sequence[Path]) -> None:
    """Delete the list if nothing is there that it names, and the empty folders that were made for it."""
    with suppress(OSError):
        if not any((folder / name).exists() for name in listed(folder)):
            (folder / OWN).unlink(missing_ok=True)
        for each in made:
            each.rmdir()


def outside_files(file: Path, named: Iterable[Path]) -> list[str]:
    """Places of the files named by a file that lie outside of its folder: by an absolute path, by `..` or by a link."""
    folder = Path(os.path.realpath(file.parent))
    places = [Path(os.path.realpath(each)) for each in named]
    return [str(place) for place in dict.fromkeys(places) if not place.is_relative_to(folder)]


def told_outside(file: Path, named: Iterable[Path]) -> str:
    """Sentence on the files named by a file that lie outside of its folder; empty if there is none."""
    found = outside_files(file, named)
    return f"{file.name} takes files from outside of its folder: {', '.join(map(repr, found))}." if found else ""


def safe_name(name: str) -> str:
    """Name without anything that could lead to another folder."""
    return re.sub(r"[^\w.-]", "_", name)
