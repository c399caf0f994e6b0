"""What a reduced model says about the files that it was built from, so that the runtime can tell whether they have changed."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

LARGEST_TEXT = 50_000
"""Bytes of a TOML file up to which the model holds its text, to say which keys have changed."""


def origin(path: Path, others: Iterable[Path], changes: Mapping[str, float]) -> dict[str, Any]:
    """Fields `inputs`, `source`, `changes` and `inputs_from` of a reduced model that a TOML file describes.

    Parameters
    ----------
    path : the TOML file
    others : the files that it names, and those that these draw on
    changes : parameters and values other than those of the file
    """
    content = path.read_bytes()
    return {
        "inputs": {_relative(each, path): hashlib.sha256(each.read_bytes()).hexdigest() for each in (path, *others)},
        "source": {path.name: content.decode(errors="replace") if len(content) <= LARGEST_TEXT else ""},
        "changes": {name: float(value) for name, value in changes.items()},
        "inputs_from": path.parent.resolve(),
    }


def _relative(file: Path, path: Path) -> str:
    return Path(os.path.relpath(file, path.parent)).as_posix()
