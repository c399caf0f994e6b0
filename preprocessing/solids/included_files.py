"""Files that a mesh file includes: they are a part of the mesh, so that a change of one builds the model anew."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

INCLUDE = re.compile(rb"^\*include\s*,[^\n]*?input\s*=\s*([^\r\n,]+)", re.IGNORECASE | re.MULTILINE)
"""A line of Abaqus."""
LARGEST, MOST = 500_000_000, 1000
"""Bytes of a file that is looked into, and files that one mesh can have."""


def included_files(path: Path) -> list[Path]:
    """The files that an Abaqus file includes, and those that these include, each once; those that do not exist too."""
    found: dict[Path, None] = {}
    waiting = [path]
    while waiting and len(found) < MOST:
        for file in _included(waiting.pop()):
            if file not in found and file != path:
                found[file] = None
                waiting.append(file)
    return list(found)


def _included(path: Path) -> Iterator[Path]:
    """Files that are named in one; relative to it."""
    if path.suffix.lower() != ".inp" or not path.is_file() or path.stat().st_size > LARGEST:
        return
    for name in INCLUDE.findall(path.read_bytes()):
        yield path.parent / name.strip().decode(errors="replace")
