"""Meshes of gmsh, .msh: which version a file is of, and what it holds."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from preprocessing.foreign_files import gmsh_version_2, gmsh_version_4
from preprocessing.foreign_files.child import LARGEST_FILE
from preprocessing.foreign_files.contents import MeshContents, refuse_leave_out, wrong_file
from preprocessing.foreign_files.gmsh_sections import (
    REMEDY,
    BinaryNumbers,
    FileSection,
    GmshBlock,
    Nodes,
    TextNumbers,
    contents,
    names_of_groups,
    sections,
)
from toolkit.foundation.files.safe_files import read_whole

FORMAT = re.compile(rb"\s*\$MeshFormat[ \t\r]*\n[ \t]*(\d)(?:\.(\d))?[ \t]+([01])[ \t]+(\d)[ \t\r]*\n")
ONCE = {"PhysicalNames", "Entities", "PartitionedEntities", "Nodes", "ParametricNodes", "Elements", "NOD", "ELM"}
"""Sections that make the mesh, each of which stands in a file once."""
OTHERS = {"MeshFormat", "Comments", "Periodic", "GhostElements", "Parametrizations", "InterpolationScheme", "NodeData", "ElementData",
          "ElementNodeData"}  # fmt: skip
"""Sections that say nothing of the mesh itself: what is periodic, parallel or a result."""


class Format(NamedTuple):
    """Format of a file, from $MeshFormat."""

    version: tuple[int, int]
    binary: bool
    size: int  # bytes of a size
    order: str  # of bytes: "<" or ">"


def gmsh_mesh(path: Path, leave_out: frozenset[str]) -> MeshContents:
    """Nodes, elements and physical groups of a .msh file.

    Raises
    ------
    InputError
        The file is of another version than 1, 2 or 4.1, or is not whole; or its sections contradict each other.
    """
    refuse_leave_out(path, leave_out, "elements that are parts of curves, surfaces or points name groups only")
    content = read_whole(path, LARGEST_FILE)
    kind = _format(path, content)
    found = sections(path, content, kind.binary)
    by_name = {section.name: section for section in found if section.name in ONCE}
    if len(by_name) < sum(section.name in ONCE for section in found):
        raise wrong_file(path, "a section stands there twice", REMEDY)
    names = names_of_groups(path, by_name["PhysicalNames"]) if "PhysicalNames" in by_name else {}
    nodes, blocks = (_version_4 if kind.version[0] == 4 else _version_2)(path, kind, by_name)
    return contents(path, nodes, blocks, names, _unknown(found))


def _unknown(found: Sequence[FileSection]) -> list[str]:
    """Remarks on sections that no version of the format has."""
    lines = [section.line for section in found if section.name not in ONCE | OTHERS]
    where = f", the first in line {lines[0]}" if lines and lines[0] else ""
    return [f"Sections that gmsh does not know were skipped: {len(lines)}{where}."] if lines else []


def _format(path: Path, content: bytes) -> Format:
    """The format of a file."""
    if content.lstrip()[:4] == b"$NOD":
        return Format((1, 0), False, 8, "<")
    found = FORMAT.match(content)
    if content.lstrip()[:1] == b"(":
        raise wrong_file(path, "it is a mesh of Ansys Fluent, of which no program of finite elements reads solids", REMEDY)
    if found is None:
        raise wrong_file(path, "it does not begin with $MeshFormat, version, 0 or 1 and a size", REMEDY)
    version, binary, size = (int(found[1]), int(found[2] or 0)), found[3] == b"1", int(found[4])
    if version[0] != 2 and version != (4, 1):
        raise wrong_file(path, "it is of another version than 1, 2 or 4.1 of the format", f"{REMEDY} {HOW}")
    if binary and (size not in (4, 8) or (version[0] == 2 and size != 8)):
        raise wrong_file(path, "$MeshFormat has another size of numbers than 8", REMEDY)
    one = content[found.end() : found.end() + 4]
    if binary and one not in (b"\1\0\0\0", b"\0\0\0\1"):
        raise wrong_file(path, "$MeshFormat has no 1 that would show the order of bytes", REMEDY)
    return Format(version, binary, size, ">" if binary and one[3] else "<")


HOW = "On the command line: gmsh in.msh -save -format msh41 -o out.msh."


def _version_4(path: Path, kind: Format, by_name: Mapping[str, FileSection]) -> tuple[Nodes, list[GmshBlock]]:
    """Nodes and elements of a file of version 4.1."""

    def opened(name: str) -> BinaryNumbers | TextNumbers:
        section = _needed(path, by_name, name)
        return BinaryNumbers(path, section, kind.size, kind.order) if kind.binary else TextNumbers(path, section)

    groups: dict[gmsh_version_4.Entity, tuple[int, ...]] = {}
    for name, read in (("Entities", gmsh_version_4.entities), ("PartitionedEntities", gmsh_version_4.partitioned_entities)):
        if name in by_name:
            numbers = opened(name)
            groups.update(read(numbers))
            numbers.finish()
    node_numbers, element_numbers = opened("Nodes"), opened("Elements")
    nodes, blocks = gmsh_version_4.nodes(path, node_numbers), gmsh_version_4.elements(path, element_numbers, groups)
    node_numbers.finish()
    element_numbers.finish()
    return nodes, blocks


def _version_2(path: Path, kind: Format, by_name: Mapping[str, FileSection]) -> tuple[Nodes, list[GmshBlock]]:
    """Nodes and elements of a file of version 1 or 2."""
    first = kind.version[0] == 1
    if kind.binary:
        return _binary_version_2(path, kind, by_name)
    parametric = not first and "ParametricNodes" in by_name
    node_numbers = TextNumbers(path, _needed(path, by_name, "NOD" if first else "ParametricNodes" if parametric else "Nodes"))
    nodes = gmsh_version_2.parametric_nodes(path, node_numbers) if parametric else gmsh_version_2.text_nodes(node_numbers)
    element_numbers = TextNumbers(path, _needed(path, by_name, "ELM" if first else "Elements"))
    blocks = gmsh_version_2.text_elements(path, element_numbers, first)
    node_numbers.finish()
    return nodes, blocks


def _binary_version_2(path: Path, kind: Format, by_name: Mapping[str, FileSection]) -> tuple[Nodes, list[GmshBlock]]:
    """Nodes and elements of a binary file of version 2, whose numbers of either stand as text on the first line."""
    found = []
    for name in ("Nodes", "Elements"):
        section = _needed(path, by_name, name)
        count, _, body = section.body.partition(b"\n")
        if not count.strip().isdigit():
            raise wrong_file(path, f"${name} does not begin with a count", REMEDY)
        found.append((int(count[:18]), BinaryNumbers(path, section._replace(body=body), kind.size, kind.order)))
    (n_nodes, node_numbers), (n_elements, element_numbers) = found
    nodes, blocks = (
        gmsh_version_2.binary_nodes(node_numbers, n_nodes),
        gmsh_version_2.binary_elements(path, element_numbers, n_elements),
    )
    node_numbers.finish()
    element_numbers.finish()
    return nodes, blocks


def _needed(path: Path, by_name: Mapping[str, FileSection], name: str) -> FileSection:
    """A section that a mesh must have."""
    if name not in by_name:
        raise wrong_file(path, f"it has no section ${name}", REMEDY)
    return by_name[name]
