"""The folder that a command writes its files into: what is there and no command has written stays; what stays empty goes."""

from __future__ import annotations

import atexit
from collections.abc import Sequence
from contextlib import suppress
from fnmatch import fnmatch
from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.replaced_file import write_whole

OWN = ".ffrf"
"""File in a folder that lists, by name or pattern, what commands have written there."""


def prepare_folder(path: Path, *names: str) -> Path:
    """Make the folder that results go to, before anything long begins; if the command puts nothing into it, it is gone at its end.

    Parameters
    ----------
    names : names or patterns of what the command will write there

    Raises
    ------
    InputError
        It cannot be made, or it is a file; or something is there by one of the names that no command has written.
    """
    made = [each for each in (path, *path.parents) if not each.exists()]
    listed = _listed(path)
    for name in names:
        foreign = next((file for file in sorted(path.glob(name)) if not any(fnmatch(file.name, own) for own in listed)), None)
        if foreign is not None:
            raise InputError(f"{str(foreign)!r} is there, and ffrf has not written it. Give another folder, or move it away.")
    try:
        path.mkdir(parents=True, exist_ok=True)
        if not set(names) <= set(listed):
            write_whole(path / OWN, "\n".join(sorted({*listed, *names})).encode())
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be made a folder ({error.strerror}). Give another with --output.") from error
    if made:
        atexit.register(_remove_empty, made)
    return path


def _listed(path: Path) -> Sequence[str]:
    own = path / OWN
    return own.read_text(encoding="utf-8", errors="replace").splitlines() if own.is_file() else []


def _remove_empty(made: Sequence[Path]) -> None:
    """Folders that hold nothing, or nothing but the list, innermost first."""
    with suppress(OSError):
        if [each.name for each in made[0].iterdir()] == [OWN]:
            (made[0] / OWN).unlink()
        for folder in made:
            folder.rmdir()
