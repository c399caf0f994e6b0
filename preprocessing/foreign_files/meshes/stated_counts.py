"""How many nodes and elements a mesh file says that it holds, in formats that say so."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from preprocessing.foreign_files.bounds import LARGEST_FILE
from toolkit.foundation.files.regular_file import read_start, read_whole

MEDIT = rb"^[ \t]*(?:Edges|Triangles|Quadrilaterals|Tetrahedra|Pyramids|Prisms|Pentahedra|Hexahedra|Hexaedra)\s+(\d{1,18})"
NETGEN = rb"^[ \t]*(?:pointelements|edgesegments\w*|surfaceelements\w*|volumeelements)[ \t\r]*\n\s*(\d{1,18})"
Counts = tuple[int | None, int | None]
"""Nodes and elements; None where the file does not say it."""


def _sums(nodes: bytes, elements: bytes) -> Callable[[Path], Counts]:
    """Sums of all numbers that stand behind certain words."""

    def count(path: Path) -> Counts:
        content = read_whole(path, LARGEST_FILE)
        found = [re.findall(each, content, re.MULTILINE | re.IGNORECASE) for each in (nodes, elements)]
        sums = [sum(map(int, each)) if each else None for each in found]
        return sums[0], sums[1]

    return count


def _first_line(path: Path, columns: tuple[int, ...]) -> list[int] | None:
    """Numbers of the first line that is no comment, at the given places."""
    for line in read_whole(path, LARGEST_FILE).split(b"\n"):
        words = line.partition(b"#")[0].split()
        if words:
            wanted = [words[k] for k in columns if k < len(words)]
            return [int(word) for word in wanted] if all(word.isdigit() and len(word) < 19 for word in wanted) else None
    return None


def _avs(path: Path) -> Counts:
    found = _first_line(path, (0, 1))
    return (found[0], found[1]) if found and len(found) == 2 else (None, None)


def _tetgen(path: Path) -> Counts:
    nodes, elements = (_first_line(path.with_suffix(ending), (0,)) for ending in (".node", ".ele"))
    return nodes[0] if nodes else None, elements[0] if elements else None


def _ugrid(path: Path) -> Counts:
    """Numbers of nodes, and of elements of six kinds, from the seven numbers at the beginning of a text."""
    words = read_start(path, 200).split()[:7] if len(path.suffixes) < 2 else []
    if len(words) < 7 or not all(word.isdigit() for word in words):
        return None, None
    return int(words[0]), sum(map(int, words[1:]))


def _dolfin(path: Path) -> Counts:
    """Numbers of nodes and elements, counted in the lists.

    meshio makes room for as many as the lists say, and leaves it as it was where one is missing.
    """
    content = read_whole(path, LARGEST_FILE)
    entries = (rb"<vertex\s", rb"<(?:interval|triangle|tetrahedron|quadrilateral|hexahedron)\s")
    nodes, elements = (len(re.findall(each, content)) for each in entries)
    return nodes, elements


STATED: dict[str, Callable[[Path], Counts]] = {
    ".su2": _sums(rb"^[ \t]*NPOIN[ \t]*=[ \t]*(\d{1,18})", rb"^[ \t]*(?:NELEM|MARKER_ELEMS)[ \t]*=[ \t]*(\d{1,18})"),
    ".mesh": _sums(rb"^[ \t]*Vertices\s+(\d{1,18})", MEDIT),
    ".vol": _sums(rb"^[ \t]*points[ \t\r]*\n\s*(\d{1,18})", NETGEN),
    ".dat": _sums(rb"\b(?:NODES|N)[ \t]*=[ \t]*(\d{1,18})", rb"\b(?:ELEMENTS|E)[ \t]*=[ \t]*(\d{1,18})"),
    ".xml": _dolfin,
    ".xdmf": _sums(rb"(?!)", rb"<Topology[^>]*NumberOfElements=[\"'](\d{1,18})[\"']"),
    ".avs": _avs,
    ".ele": _tetgen,
    ".node": _tetgen,
    ".ugrid": _ugrid,
}
"""Ending of a file -> what it says."""
STATED |= {".tec": STATED[".dat"], ".xmf": STATED[".xdmf"]}


def stated_counts(path: Path) -> Counts:
    """Nodes and elements that a file says it holds; None where its format does not say so."""
    count = STATED.get(path.suffix.lower())
    return count(path) if count else (None, None)
