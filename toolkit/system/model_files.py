"""Check that the files of reduced models are those that a scene was compiled with."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene

FileStates = Mapping[Path, tuple[int, int] | None]
"""File -> when it was written, in ns, and its size; None if it was not there."""


def file_states(scene: Scene) -> FileStates:
    """Present states of all files that a scene names, those of reduced models and of a kept start."""
    return {path: _state(path) for path in scene.read_files()}


def refuse_changed(states: FileStates) -> None:
    """Refuse to go on where a file is not in the state that it was in.

    Raises
    ------
    InputError
        Names the file: half of the numbers would be those of another body.
    """
    for path, state in states.items():
        if _state(path) != state:
            raise InputError(
                f"the file {str(path)!r} has changed since the scene was compiled, or is not there any more, so that half of the "
                "numbers would be those of another body, or of another start. Compile the scene again."
            )


def _state(path: Path) -> tuple[int, int] | None:
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size
