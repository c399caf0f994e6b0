"""Files that the program has written into a folder: a list beside them tells what it may replace, and what to take away.

Whoever writes a set of files into a folder refuses before anything long what is there of these names and not in the list
(`refuse_foreign`), and lists the names when it begins to write (`list_own`): files of an earlier set that are not written again go.
If nothing comes of it, what was made for it goes too (`own_set`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from fnmatch import fnmatchcase
from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.replaced_file import write_whole

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
