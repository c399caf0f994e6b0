"""Where in an input file an error arose."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from toolkit.foundation.errors import InputError


@contextmanager
def at_key(path: Path, key: str) -> Iterator[None]:
    """Add to an input error the file and the key at which it arose."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{str(path)!r}, {key}: {error}") from error
