"""What numbers follow from, as hashes: of anything that JSON can hold, and of the program itself."""

from __future__ import annotations

import json
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import toolkit

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
