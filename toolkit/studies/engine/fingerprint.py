"""Fingerprints: hashes of all that an outcome follows from, so that a store never gives an outcome of something else."""

from __future__ import annotations

import json
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import toolkit
from toolkit.scene.scene import Scene

UNINVOLVED = ("cli", "command_line", "report", "render", "results", "conformance")
"""Parts of the toolkit that no run goes through."""


def hashed(*parts: Any) -> str:
    """Hash of anything that JSON can hold; numbers count with all their digits."""
    return sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:32]


@cache
def program() -> str:
    """Hash of all files of the toolkit that a run goes through."""
    root = Path(toolkit.__file__ or "").parent
    files = [path for path in sorted(root.rglob("*.py")) if path.relative_to(root).with_suffix("").parts[0] not in UNINVOLVED]
    return sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


def file_hashes(files: list[Path]) -> list[str]:
    """Hashes of the content of files; "missing" stands for one that cannot be read."""
    return [sha256(path.read_bytes()).hexdigest() if path.is_file() else "missing" for path in files]


def scene_fingerprint(scene: Scene, *parts: Any) -> str:
    """Hash of a scene, of the content of its files wherever these lie, of the program, and of what else an outcome follows from."""
    described = repr(scene.model_copy(update={"directory": Path()}))
    return hashed(described, file_hashes(scene.read_files()), parts, program())
