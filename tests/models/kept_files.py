"""Files of reduced models that many tests ask for: built once by each process, as the same numbers give the same bytes."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from pathlib import Path
from tempfile import TemporaryDirectory

_KEPT: dict[Hashable, dict[str, bytes]] = {}


def write_once(folder: Path, key: Hashable, write: Callable[[Path], object]) -> None:
    """Fill a folder with the files that `write` writes into one; the second time for the same key with what they were the first time."""
    if key not in _KEPT:
        with TemporaryDirectory() as own:
            write(Path(own))
            _KEPT[key] = {file.name: file.read_bytes() for file in Path(own).iterdir()}
    for name, content in _KEPT[key].items():
        (folder / name).write_bytes(content)
