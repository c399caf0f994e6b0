"""Names of files that somebody wrote: those that no file can have, and what was probably meant by a path that leads nowhere."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

from toolkit.foundation.listed_names import meant

MOST = 1000
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
        return meant(missing.name, [each.name for each in islice(missing.parent.iterdir(), MOST)])
    except OSError:
        return ""
