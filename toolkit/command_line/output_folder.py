"""The folder that a command writes its files into: what is there and no command has written stays; what stays empty goes."""

from __future__ import annotations

import atexit
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.own_files import OWN, list_own, refuse_foreign


def prepare_folder(path: Path, *names: str) -> Path:
    """Make the folder that results go to, before anything long begins; if the command puts nothing into it, it is gone at its end.

    Parameters
    ----------
    names : what the command will write there

    Raises
    ------
    InputError
        It cannot be made, or it is a file; or something is there by one of the names that no command has written.
    """
    made = [each for each in (path, *path.parents) if not each.exists()]
    refuse_foreign(path, names)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be made a folder ({error.strerror}). Give another with --output.") from error
    list_own(path, names)
    if made:
        atexit.register(_remove_empty, made)
    return path


def _remove_empty(made: Sequence[Path]) -> None:
    """Folders that hold nothing, or nothing but the list, innermost first."""
    with suppress(OSError):
        if [each.name for each in made[0].iterdir()] == [OWN]:
            (made[0] / OWN).unlink()
        for folder in made:
            folder.rmdir()
