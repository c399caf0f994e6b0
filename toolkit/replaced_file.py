"""Files in one stroke: written under a temporary name, then renamed; an interrupted run leaves the old file or none."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from toolkit.errors import InputError


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A temporary file beside `path` to write to; it takes the name of `path` if nothing was raised.

    A process that is killed leaves it behind (NAME....tmp.h5). Nothing reads such files and nothing deletes them, since another
    process might be writing to them: that is left to the user.

    Raises
    ------
    InputError
        The place cannot be written to, or is full.
    """
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.stem, suffix=f".tmp{path.suffix}")
        os.close(handle)
        temporary = Path(name)
        try:
            yield temporary
            mask = os.umask(0)
            os.umask(mask)
            temporary.chmod(0o666 & ~mask)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be written ({error.strerror or error}). Give a writable place.") from error
