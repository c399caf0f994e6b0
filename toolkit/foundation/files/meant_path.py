"""What was probably meant by a path that leads nowhere."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

from toolkit.foundation.listed_names import meant

MOST = 1000
"""Names of a folder that are looked at."""


def meant_path(path: Path, error: OSError) -> str:
    """What the first missing part of a path was meant to be, as a part of a sentence; empty if nothing is like it or missing."""
    if not isinstance(error, FileNotFoundError):
        return ""
    missing = path
    while not missing.parent.is_dir():
        missing = missing.parent
    try:
        return meant(missing.name, [each.name for each in islice(missing.parent.iterdir(), MOST)])
    except OSError:
        return ""
