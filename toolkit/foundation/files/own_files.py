"""What commands have written into a folder: a list beside it, by which they know what they may replace."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatch
from pathlib import Path

from toolkit.foundation.files.replaced_file import write_whole

OWN = ".ffrf"
"""File in a folder that lists, by name or pattern, what commands have written there."""


def listed(folder: Path) -> Sequence[str]:
    """Names and patterns in the list of a folder; none where there is no list."""
    own = folder / OWN
    return own.read_text(encoding="utf-8", errors="replace").splitlines() if own.is_file() else []


def foreign(folder: Path, names: Sequence[str]) -> Path | None:
    """The first file of these names or patterns that no command has written; None if there is none."""
    known = listed(folder)
    found = (file for name in names for file in sorted(folder.glob(name)))
    return next((file for file in found if not any(fnmatch(file.name, own) for own in known)), None)


def list_own(folder: Path, names: Sequence[str]) -> None:
    """Add names or patterns to the list.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    known = listed(folder)
    if not set(names) <= set(known):
        write_whole(folder / OWN, "\n".join(sorted({*known, *names})).encode())
