"""Files that a mesh file draws on: what Abaqus includes, the data of XDMF, the other half of TetGen's pairs."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from xml.etree import ElementTree

from toolkit.errors import InputError

INCLUDE = re.compile(rb"^\s*\*include\s*,.*=\s*(\S.*?)\s*$", re.IGNORECASE | re.MULTILINE)
"""The line *INCLUDE, INPUT=file, which the reader of meshes takes for the part behind its last equals sign."""
PAIRS = {".node": ".ele", ".ele": ".node"}


def drawn_on(path: Path) -> list[Path]:
    """All files that a mesh file names, and those that these name, in their order; itself is not among them.

    Raises
    ------
    InputError
        A file is there twice: where the reader of meshes looks first, and beside the file that names it.
    """
    found: dict[Path, None] = {}

    def follow(each: Path) -> None:
        for named in _named(each):
            if named not in found and named != path:
                found[named] = None
                follow(named)

    follow(path)
    return list(found)


def _named(path: Path) -> Iterator[Path]:
    of_kind: dict[str, Callable[[Path], Iterator[Path]]] = {
        ".inp": _abaqus,
        ".xdmf": _xdmf,
        ".xmf": _xdmf,
        ".node": _pair,
        ".ele": _pair,
    }
    if path.suffix.lower() in of_kind and path.is_file():
        yield from of_kind[path.suffix.lower()](path)


def _abaqus(path: Path) -> Iterator[Path]:
    for name in INCLUDE.findall(path.read_bytes()):
        here, beside = Path(name.decode(errors="surrogateescape")), path.parent / name.decode(errors="surrogateescape")
        if here.exists() and beside.exists() and not here.samefile(beside):
            raise InputError(
                f"{str(path)!r} includes {str(here)!r}, and there are two such files: {str(here.resolve())!r} in the folder of this "
                f"command, which the reader of meshes would take, and {str(beside)!r}. Work in another folder, or rename one of them."
            )
        yield beside if beside.exists() else here


def _xdmf(path: Path) -> Iterator[Path]:
    try:
        items = list(ElementTree.fromstring(path.read_bytes()).iter())
    except ElementTree.ParseError:
        return  # the reader of meshes will say so
    for item in items:
        kind = item.get("Format", "").upper()
        text = (item.text or "").strip()
        if kind == "HDF" and ":" in text:
            yield path.parent / text.rsplit(":", 1)[0]
        elif kind == "BINARY" and text:
            yield path.parent / text
        elif item.get("href"):
            yield path.parent / str(item.get("href"))


def _pair(path: Path) -> Iterator[Path]:
    yield path.with_suffix(PAIRS[path.suffix.lower()])
