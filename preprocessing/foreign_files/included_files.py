"""Files that a mesh file draws on: what Abaqus and Nastran include, the data of XDMF, the other half of TetGen's pairs."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

from preprocessing.foreign_files.abaqus.blocks import deck_files
from preprocessing.foreign_files.child import LARGEST_FILE
from preprocessing.foreign_files.nastran.lines import named_files
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import meant_path, read_whole

DEEPEST_INCLUDE, MOST_FILES = 20, 1000
"""Files that include each other in a row, and files in all, that any mesh is made of."""
PAIRS = {".node": ".ele", ".ele": ".node"}
INCLUDING: dict[str, Callable[[Path, Path, bytes], Iterator[Path]]] = {
    ".inp": deck_files,
    **dict.fromkeys((".bdf", ".nas", ".fem", ".blk"), named_files),
}
"""Ending of a deck or of bulk data -> the files that it, or one that it includes, takes lines from; those may have any ending."""


def drawn_on(path: Path) -> list[Path]:
    """Files that a mesh file names, and those that these name, in their order, without itself.

    Raises
    ------
    InputError
        A file is there twice: where the reader of meshes looks first, and beside the file that names it. Or files include themselves, are
        too many, too large, or no regular files.
    """
    found: dict[Path, None] = {}

    def follow(each: Path, chain: tuple[str, ...]) -> None:
        for named in _named(path, each):
            place = os.path.realpath(named)
            if not os.path.lexists(named) and not _is_pair(named):
                raise InputError(
                    f"{str(each)!r} names {str(named)!r}, and there is none{meant_path(named, FileNotFoundError())}. Put it there: "
                    "files are sought from the folder of the mesh file, and from that of the file which names them."
                )
            if place in chain and not _is_pair(named):
                raise InputError(
                    f"{str(each)!r} includes {str(named)!r}, which includes it in turn. Take one of the two lines out."
                )
            if len(chain) > DEEPEST_INCLUDE or len(found) > MOST_FILES:
                raise InputError(
                    f"{str(path)!r} includes more than {MOST_FILES} files, or more than {DEEPEST_INCLUDE} in a row. Write the "
                    "mesh in one file."
                )
            if named not in found and named != path:
                found[named] = None
                follow(named, (*chain, place))

    follow(path, (os.path.realpath(path),))
    return list(found)


def _is_pair(path: Path) -> bool:
    return path.suffix.lower() in PAIRS


def _named(main: Path, path: Path) -> Iterator[Path]:
    of_kind: dict[str, Callable[[Path, bytes], Iterator[Path]]] = {
        ".xdmf": _xdmf,
        ".xmf": _xdmf,
        ".node": _pair,
        ".ele": _pair,
    }
    kind = path.suffix.lower()
    if including := INCLUDING.get(main.suffix.lower()):
        kind, of_kind = "", {"": lambda path, content: including(main, path, content)}
    if kind in of_kind and os.path.lexists(path):
        yield from (each for each in of_kind[kind](path, _content(path)) if "\0" not in str(each))  # that is no path


def _content(path: Path) -> bytes:
    try:
        return read_whole(path, LARGEST_FILE)
    except FileNotFoundError:  # a link to nothing, which the reader of meshes will say
        return b""
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read ({error.strerror}). Fix the path, or give a regular file.") from error


def _where(path: Path, name: str) -> Path:
    """File that a name means, for which the reader of meshes looks in the current folder first."""
    here, beside = Path(name), path.parent / name
    if os.path.exists(here) and os.path.exists(beside) and not os.path.samefile(here, beside):
        raise InputError(
            f"{str(path)!r} includes {str(here)!r}, and there are two such files: {str(here.resolve())!r} in the folder of this "
            f"command, which the reader of meshes would take, and {str(beside)!r}. Work in another folder, or rename one of them."
        )
    return here if os.path.exists(here) and not os.path.exists(beside) else beside


def _xdmf(path: Path, content: bytes) -> Iterator[Path]:
    try:
        for _, item in ElementTree.iterparse(BytesIO(content)):
            kind, text = item.get("Format", "").upper(), (item.text or "").strip()
            if kind == "HDF" and ":" in text:
                yield path.parent / text.split(":", 1)[0].strip()
            elif kind == "BINARY" and text:
                yield _where(path, text)
            elif item.get("href"):
                yield path.parent / str(item.get("href"))
            item.clear()
    except (ElementTree.ParseError, LookupError, ValueError):
        return  # the reader of meshes will say so


def _pair(path: Path, _: bytes) -> Iterator[Path]:
    yield path.with_suffix(PAIRS[path.suffix.lower()])
