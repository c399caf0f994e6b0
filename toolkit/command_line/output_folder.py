"""The folder that a command writes its files into: what is there and no command has written stays; what stays empty goes."""

from __future__ import annotations

import atexit
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.own_files import OWN, foreign, list_own


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
    if (there := foreign(path, names)) is not None:
        raise InputError(f"{str(there)!r} is there, and ffrf has not written it. Give another folder, or move it away.")
    try:
        path.mkdir(parents=True, exist_ok=True)
        list_own(path, names)
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be made a folder ({error.strerror}). Give another with --output.") from error
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
