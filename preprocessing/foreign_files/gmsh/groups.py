"""Physical groups of gmsh: their names, and the elements that have them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from preprocessing.foreign_files.contents import Elements
from preprocessing.foreign_files.gmsh.kinds import DIMENSIONS
from preprocessing.foreign_files.gmsh.sections import REMEDY, Section
from preprocessing.foreign_files.meshes.wrong_file import wrong_file

Group = tuple[int, int]
"""Dimension and positive tag of a physical group."""
NAME = re.compile(rb'\s*([0-3])\s+(-?\d{1,18})\s+"(.*)"\s*')


def names_of_groups(path: Path, section: Section) -> dict[Group, str]:
    """Names that $PhysicalNames gives to groups.

    Raises
    ------
    InputError
        A line is not dimension, tag and name in quotation marks, or there are more or fewer lines than the section says.
    """
    head, _, rest = section.body.strip().partition(b"\n")
    lines = [line for line in rest.split(b"\n") if line.strip()]
    if not head.strip().isdigit() or int(head.strip()[:18]) != len(lines):
        raise wrong_file(path, "$PhysicalNames has not as many lines as it says", REMEDY, section.line)
    names = {}
    for k, line in enumerate(lines):
        found = NAME.fullmatch(line)
        if found is None:
            raise wrong_file(
                path, "a line of $PhysicalNames is not dimension, tag and name in quotation marks", REMEDY, section.line + k + 1
            )
        names[int(found[1]), abs(int(found[2]))] = found[3].decode("utf-8", "backslashreplace")
    return names


def named_groups(members: Mapping[Group, Elements], names: Mapping[Group, str]) -> tuple[list[tuple[str, Elements]], list[str]]:
    """Groups by their names, and remarks that the user should know.

    A name that gmsh gives to groups of several dimensions stands for none of them alone: they are called, for example, "tip (curve 4)"
    and "tip (surface 2)". A group without a name is called after its dimension and tag, for example "physical surface 3".
    """
    every = dict.fromkeys([*names, *members])
    dimensions: dict[str, set[int]] = {}
    for dimension, tag in names:
        dimensions.setdefault(names[dimension, tag], set()).add(dimension)
    together: dict[str, list[Group]] = {}
    for group in every:
        together.setdefault(_name(group, names.get(group), dimensions), []).append(group)
    found = [(name, _union([members.get(group, []) for group in groups])) for name, groups in together.items()]
    return found, [*_remarks(dimensions, together), *_without_elements(names, members)]


def _name(group: Group, name: str | None, dimensions: Mapping[str, set[int]]) -> str:
    """Name of a group."""
    which = f"{DIMENSIONS[group[0]]} {group[1]}"
    if name is None:
        return f"physical {which}"
    return name if len(dimensions[name]) == 1 else f"{name} ({which})"


def _remarks(dimensions: Mapping[str, set[int]], together: Mapping[str, list[Group]]) -> list[str]:
    """Remarks on names of several groups."""
    several = [
        f"The name {name!r} is of groups of several dimensions ({', '.join(DIMENSIONS[each] for each in sorted(of))}), which are called "
        f"'{name} ({DIMENSIONS[max(of)]} TAG)' and so on."
        for name, of in dimensions.items()
        if len(of) > 1
    ]
    same = [
        f"The group {name!r} is made of {len(groups)} physical groups of this name."
        for name, groups in together.items()
        if len(groups) > 1
    ]
    return several + same


def _without_elements(names: Mapping[Group, str], members: Mapping[Group, Elements]) -> list[str]:
    """Remark that groups are named and have no elements, as gmsh writes MSH 2.2 with Mesh.SaveAll."""
    empty = [group for group in names if not members.get(group)]
    if not empty:
        return []
    return [
        f"{len(empty)} of {len(names)} named groups have no elements in the file. gmsh leaves groups out where it saves all elements "
        "(Mesh.SaveAll) in MSH 1 or 2.2: save MSH 4.1."
    ]


def _union(parts: list[Elements]) -> Elements:
    """All elements of several groups, each once."""
    if len(parts) == 1:
        return parts[0]
    kinds = dict.fromkeys(kind for part in parts for kind, _ in part)
    return [(kind, _once([nodes for part in parts for other, nodes in part if other == kind])) for kind in kinds]


def _once(blocks: list[np.ndarray]) -> np.ndarray:
    """Elements of several blocks without repetition, in their order; a curve may be in one group against its direction."""
    every = np.concatenate(blocks)
    _, first = np.unique(np.sort(every, axis=1), axis=0, return_index=True)
    return every[np.sort(first)]
