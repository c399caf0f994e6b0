"""Measured runs on disk, one file each: maps that were interrupted go on where they stopped.

A file's name is the hash of all that its content follows from. What belongs to a scene, a model or a program that has changed since is
never read again; it may be deleted at any time.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from toolkit.foundation.files.replaced_file import write_whole
from toolkit.scene.scene import Scene
from toolkit.studies.identity import hashed, program
from toolkit.studies.stability.measure import Measured

_MEASURED = TypeAdapter(Measured)


class KeptRuns:
    """The runs of one folder, which is made; None keeps nothing."""

    def __init__(self, folder: Path | None) -> None:
        self.folder = folder
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)

    def find(self, key: str) -> Measured | None:
        """The run of a key; None if there is none, or its file is damaged."""
        if self.folder is None:
            return None
        try:
            return _MEASURED.validate_python(json.loads(self._file(key).read_bytes()))
        except (OSError, ValueError, ValidationError):
            return None

    def keep(self, key: str, found: Measured) -> None:
        """Write a run in one stroke."""
        if self.folder is not None:
            write_whole(self._file(key), json.dumps(asdict(found), default=float).encode())

    def _file(self, key: str) -> Path:
        return (self.folder or Path()) / f"{key}.json"


def fingerprint(scene: Scene, design: list[str], sizes: Mapping[str, float] | None, both_methods: bool) -> str:
    """Hash of what a run follows from: the scene with its files, wherever these lie, and the program."""
    content = [sha256(path.read_bytes()).hexdigest() for path in scene.read_files()]
    described = repr(scene.model_copy(update={"directory": Path()}))
    return hashed(described, content, design, None if sizes is None else dict(sizes), both_methods, program())
