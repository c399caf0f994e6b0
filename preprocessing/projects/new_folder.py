"""The folder of a new project: nothing that is there is overwritten."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.replaced_file import write_whole


def refuse_occupied(folder: Path) -> None:
    """Refuse a folder that is not empty.

    Raises
    ------
    InputError
        It is a file, or not empty.
    """
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        what = "is not empty" if folder.is_dir() else "is a file"
        raise InputError(f"{str(folder)!r} {what}, and nothing of yours shall be overwritten. Name a new folder.")


def write_folder(folder: Path, content: Mapping[str, bytes]) -> list[Path]:
    """Make the folder and write its files, which may lie in folders of their own.

    Raises
    ------
    InputError
        It cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, data in content.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            write_whole(folder / name, data)
    except OSError as error:
        raise InputError(f"{str(folder)!r} cannot be written ({error.strerror}). Name another folder.") from error
    return [folder / name for name in content]


def substituted(texts: Mapping[str, object], numbers: Mapping[str, object]) -> dict[str, bytes]:
    """Files of templates (`string.Template`) with their places filled."""
    return {name: text.substitute(numbers).encode() for name, text in texts.items()}  # type: ignore[attr-defined]
