"""Mesh files as bytes, and the errors of those that cannot be read as they are."""

from __future__ import annotations

from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.regular_file import read_start, size_of


def content_of(path: Path) -> bytes:
    """All bytes of a file, whose size the caller has bounded; no more memory is asked for than they take."""
    return read_start(path, size_of(path))


def wrong_file(path: Path, what: str, remedy: str, line: int = 0) -> InputError:
    """The error of a mesh file: what is wrong, in which line if that is known, and what to do."""
    where = f"line {line}: " if line else ""
    return InputError(f"the mesh {str(path)!r} cannot be read ({where}{what}). {remedy}")


def refuse_leave_out(path: Path, leave_out: frozenset[str], why: str) -> None:
    """Refuse names in leave_out where the format has nothing that could be left out."""
    if leave_out:
        raise InputError(
            f"leave_out in [mesh] names {', '.join(sorted(leave_out))}, but {why}, so that nothing of {str(path)!r} can be left out. "
            "Take leave_out away."
        )
