"""Where a file is that a deck or a bulk file includes."""

from __future__ import annotations

import os
from pathlib import Path

from toolkit.foundation.errors import InputError


def included_file(main: Path, including: Path, name: str) -> Path:
    """The file that is meant by a name: sought from the folder of the main file, as solvers do that start there, else beside the file that
    names it.

    Raises
    ------
    InputError
        There are two such files, one in each of these folders.
    """
    plain = name.strip().strip("\"'").strip()
    from_main, beside = main.parent / plain, including.parent / plain
    if not os.path.lexists(from_main):
        return beside
    if os.path.lexists(beside) and os.path.realpath(from_main) != os.path.realpath(beside):
        raise InputError(
            f"{str(including)!r} includes a file that there is twice: {str(from_main)!r} and {str(beside)!r}. Rename one of them."
        )
    return from_main
