"""Files that a scene or the description of a body takes from elsewhere: allowed, as in shared folders of models, but told."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path


def outside_files(file: Path, named: Iterable[Path]) -> list[str]:
    """Places of the files named by a file that lie outside of its folder: by an absolute path, by `..` or by a link."""
    folder = Path(os.path.realpath(file.parent))
    places = [Path(os.path.realpath(each)) for each in named]
    return [str(place) for place in dict.fromkeys(places) if not place.is_relative_to(folder)]


def told_outside(file: Path, named: Iterable[Path]) -> str:
    """Sentence on the files named by a file that lie outside of its folder; empty if there is none."""
    found = outside_files(file, named)
    return f"{file.name} takes files from outside of its folder: {', '.join(map(repr, found))}." if found else ""
