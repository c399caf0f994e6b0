"""What a body is, in words: one line for the terminal after it was built, and a few lines for whoever looks into its file."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

NAMES = {
    "beam": ("beam", "beams"),
    "triangle": ("triangle", "triangles"),
    "quad": ("quadrilateral", "quadrilaterals"),
    "tetra": ("tetrahedron", "tetrahedra"),
    "hexahedron": ("hexahedron", "hexahedra"),
    "wedge": ("wedge", "wedges"),
    "pyramid": ("pyramid", "pyramids"),
}
"""Beginning of a kind of elements -> what one and what several are called."""
POINTS_IN_LINE = 4
"""Interface points that the one line names; the others are counted."""


def body_line(name: str, summary: Mapping[str, Any]) -> str:
    """One line: elements, mass, centre, volume, interface points, and what was left out."""
    units = summary["units"]
    made = [f"{summary['mass']:.6g} {units['mass']} at {_place(summary['centre'])} {units['centre']}"]
    if summary["volume"] is not None:
        made.append(f"{summary['volume']:.6g} {units['volume']}")
    if told := told_elements(summary):
        made.insert(0, told)
    parts = [", ".join(made), *_points_in_line(summary)]
    if summary["left_out"]:
        parts.append(f"left out: {told_left_out(summary['left_out'])}")
    return f"{name}: {'; '.join(parts)}."


def body_lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """The same with everything that is known, one thing a line."""
    units = summary["units"]
    yield f"mass: {summary['mass']:.6g} {units['mass']}"
    yield f"centre: {_place(summary['centre'])} {units['centre']}"
    yield f"inertia about the centre: {_told_inertia(summary['inertia'])} {units['inertia']}"
    yield "volume: " + ("not known" if summary["volume"] is None else f"{summary['volume']:.6g} {units['volume']}")
    yield f"elements: {told_elements(summary) or 'not known'}"
    if summary["clamp"]:
        yield f"clamp: {_told_nodes(summary['clamp'], units)}"
    for kind, words in (("interface_points", "interface point"), ("groups", "group")):
        yield from (f"{words} {name}: {_told_nodes(each, units)}" for name, each in summary[kind].items())
    for each in summary["masses"]:
        yield f"mass of {each['mass']:.6g} {units['mass']} at {_place(each['position'])} {units['position']}, by {each['source']}"
    if summary["nodes"] is not None:
        yield f"left out of the mesh file: {told_left_out(summary['left_out']) or 'nothing'}"
    yield from (f"remark: {each}" for each in summary["remarks"])
    yield from (f"and {count} more {name.replace('_', ' ')}, which are not kept" for name, count in summary["not_listed"].items())


def told_elements(summary: Mapping[str, Any]) -> str:
    """Number of elements by kind, and of nodes; empty where neither is known."""
    kinds = " and ".join(_kind(kind, number) for kind, number in (summary["elements"] or {}).items())
    nodes = "" if summary["nodes"] is None else f"{summary['nodes']} nodes"
    return f"{kinds} ({nodes} in all)" if kinds and nodes else kinds or nodes


def told_left_out(left_out: Sequence[Mapping[str, Any]]) -> str:
    """What stands in a mesh file and is not part of the body: how many of what, and why."""
    return ", ".join(f"{each['number']} {each['what']} ({each['why']})" for each in left_out)


def _kind(kind: str, number: int) -> str:
    """For example "4 hexahedra", or "11 hexahedra with 20 nodes each"."""
    found = re.fullmatch(r"([a-z]+)(\d*)", kind)
    if found is None or found[1] not in NAMES:
        return f"{number} {kind}"
    each = f" with {found[2]} nodes{' each' * (number != 1)}" if found[2] else ""
    return f"{number} {NAMES[found[1]][number != 1]}{each}"


def _points_in_line(summary: Mapping[str, Any]) -> Iterator[str]:
    points = list(summary["interface_points"].items())
    for name, point in points[:POINTS_IN_LINE]:
        nodes = "" if point["nodes"] is None else f", {_count(point['nodes'])}"
        yield f"{name} at {_place(point['position'])}{nodes}"
    if len(points) > POINTS_IN_LINE:
        yield f"and {len(points) - POINTS_IN_LINE} more interface points"


def _told_nodes(each: Mapping[str, Any], units: Mapping[str, str]) -> str:
    """Where some nodes are and how many they are."""
    where = "nowhere" if each["position"] is None else f"{_place(each['position'])} {units['position']}"
    return where if each["nodes"] is None else f"{where}, {_count(each['nodes'])}"


def _told_inertia(inertia: Any) -> str:
    if not isinstance(inertia, list):
        return f"{inertia:.6g}"
    pairs = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    return ", ".join(f"{name} {inertia[i][j]:.6g}" for name, (i, j) in pairs.items() if i == j or inertia[i][j])


def _count(nodes: int) -> str:
    return "1 node" if nodes == 1 else f"{nodes} nodes"


def _place(position: Sequence[float]) -> str:
    return f"({', '.join(f'{x:.6g}' for x in position)})"
