"""The folder that a command writes its files into: what is there and no command has written stays; what stays empty goes."""

from __future__ import annotations

import atexit
from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.own_files import leave_nothing, list_own, missing, refuse_foreign


def prepare_folder(path: Path, *names: str) -> Path:
    """Make the folder for results before anything long begins; it is removed at the end if the command leaves it empty.

    Parameters
    ----------
    names : what the command will write there

    Raises
    ------
    InputError
        It cannot be made, or it is a file; or something is there by one of the names that no command has written.
    """
    made = missing(path)
    refuse_foreign(path, names)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be made a folder ({error.strerror}). Give another with --output.") from error
    atexit.register(leave_nothing, path, made)
    list_own(path, names)
    return path
