"""The files that a mesh is made of, for a folder that shall hold them all."""

from __future__ import annotations

import os
from collections.abc import Collection
from pathlib import Path

from preprocessing.foreign_files.bounds import LARGEST_FILE
from preprocessing.foreign_files.included_files import drawn_on
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.regular_file import read_whole


def mesh_files(path: Path, reserved: Collection[str]) -> dict[str, bytes]:
    """Place relative to the mesh's folder -> content, of a mesh and of all files that it includes or draws on.

    Parameters
    ----------
    path : the mesh
    reserved : names that other files of the new folder will have

    Raises
    ------
    InputError
        A file lies outside of the mesh's folder, is named by an absolute path, cannot be read, or has a reserved name.
    """
    mesh = Path(os.path.relpath(path))  # absolute are only the files that are named so
    files = {mesh.name: mesh} | {_place(path, mesh, each): each for each in drawn_on(mesh)}
    for place in files:
        if Path(place).parts[0].casefold() in {name.casefold() for name in reserved}:
            raise InputError(
                f"the mesh {str(path)!r} is made of a file {place!r}, and the new folder gets one of that name. Rename it, or write the "
                "mesh in one file."
            )
    return {place: _content(each) for place, each in files.items()}


def _place(path: Path, mesh: Path, each: Path) -> str:
    """Where a file that the mesh draws on lies, as seen from the mesh's folder."""
    place = Path(os.path.relpath(each, mesh.parent))
    if each.is_absolute() or place.parts[0] == os.pardir:
        how = "by its absolute path" if each.is_absolute() else "outside of its own folder"
        raise InputError(
            f"the mesh {str(path)!r} includes {str(each)!r} {how}, so that a copy of both would still read the old one. Put that file "
            "beside the mesh or below it and include it from there, or write the mesh in one file."
        )
    return place.as_posix()


def _content(each: Path) -> bytes:
    try:
        return read_whole(each, LARGEST_FILE)
    except OSError as error:
        raise InputError(f"{str(each)!r} cannot be read ({error.strerror}). Fix the path, or give a regular file.") from error
