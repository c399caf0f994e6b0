"""What a body is, in words: one line for the terminal after it was built, and a few lines for whoever looks into its file."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from math import sqrt
from typing import TypedDict


class NodesRecord(TypedDict):
    """Mean position of some nodes, None if there are none, and their number, None if nobody knows it."""

    position: list[float] | None
    nodes: int | None


class MassRecord(TypedDict):
    """Concentrated mass of a body, where it is, how many nodes carry it, and the line of the mesh file that it stands in."""

    mass: float
    position: list[float]
    nodes: int
    source: str


class PointRecord(TypedDict):
    """Position of an interface point, and the number of nodes that carry it, None if nobody knows it."""

    position: list[float]
    nodes: int | None


class BodySummary(TypedDict):
    """What a body is, as numbers, see `body_summary`."""

    mass: float
    centre: list[float]
    inertia: float | list[list[float]]
    volume: float | None
    nodes: int | None
    elements: dict[str, int] | None
    units: dict[str, str]
    interface_points: dict[str, PointRecord]
    clamp: NodesRecord | None
    groups: dict[str, NodesRecord]
    masses: list[MassRecord]
    left_out: list[dict[str, object]]
    remarks: list[str]
    not_listed: dict[str, int]


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
ZERO_COORDINATE = 1e-5
"""Part of the body's radius of gyration below which a coordinate is told as zero."""
MOST_NAMED_POINTS = 4
"""Interface points that the one line names; the others are counted."""


def body_line(name: str, summary: BodySummary) -> str:
    """Body in one line: elements, mass, centre, volume, interface points, and what was left out."""
    units = summary["units"]
    made = [f"{summary['mass']:.6g} {units['mass']} at {told_place(summary['centre'], summary)} {units['centre']}"]
    if summary["volume"] is not None:
        made.append(f"{summary['volume']:.6g} {units['volume']}")
    if told := told_elements(summary):
        made.insert(0, told)
    parts = [", ".join(made), *_points_in_line(summary)]
    if summary["left_out"]:
        parts.append(f"left out: {told_left_out(summary['left_out'])}")
    return f"{name}: {'; '.join(parts)}."


def body_lines(summary: BodySummary) -> Iterator[str]:
    """Body in several lines with everything that is known, one item a line."""
    units = summary["units"]
    yield f"mass: {summary['mass']:.6g} {units['mass']}"
    yield f"centre: {told_place(summary['centre'], summary)} {units['centre']}"
    yield f"inertia about the centre: {_told_inertia(summary['inertia'])} {units['inertia']}"
    yield "volume: " + ("not known" if summary["volume"] is None else f"{summary['volume']:.6g} {units['volume']}")
    yield f"elements: {told_elements(summary) or 'not known'}"
    if summary["clamp"]:
        yield f"clamp: {_told_nodes(summary['clamp'], summary)}"
    yield from (f"interface point {name}: {_told_nodes(each, summary)}" for name, each in summary["interface_points"].items())
    yield from (f"group {name}: {_told_nodes(each, summary)}" for name, each in summary["groups"].items())
    for mass in summary["masses"]:
        place = f"{told_place(mass['position'], summary)} {units['position']}"
        yield f"mass of {mass['mass']:.6g} {units['mass']} at {place}, by {mass['source']}"
    if summary["nodes"] is not None:
        yield f"left out of the mesh file: {told_left_out(summary['left_out']) or 'nothing'}"
    yield from (f"remark: {each}" for each in summary["remarks"])
    yield from (f"and {count} more {name.replace('_', ' ')}, which are not kept" for name, count in summary["not_listed"].items())


def told_elements(summary: BodySummary) -> str:
    """Number of elements by kind, and of nodes; empty where neither is known."""
    kinds = " and ".join(_kind(kind, number) for kind, number in (summary["elements"] or {}).items())
    nodes = "" if summary["nodes"] is None else f"{summary['nodes']} nodes"
    return f"{kinds} ({nodes} in all)" if kinds and nodes else kinds or nodes


def told_left_out(left_out: Sequence[Mapping[str, object]]) -> str:
    """Entries of a mesh file that are not part of the body, in words: how many of what, and why."""
    return ", ".join(f"{each['number']} {each['what']} ({each['why']})" for each in left_out)


def _kind(kind: str, number: int) -> str:
    """Number and kind of elements in words, for example "4 hexahedra", or "11 hexahedra with 20 nodes each"."""
    found = re.fullmatch(r"([a-z]+)(\d*)", kind)
    if found is None or found[1] not in NAMES:
        return f"{number} {kind}"
    each = f" with {found[2]} nodes{' each' * (number != 1)}" if found[2] else ""
    return f"{number} {NAMES[found[1]][number != 1]}{each}"


def _points_in_line(summary: BodySummary) -> Iterator[str]:
    points = list(summary["interface_points"].items())
    for name, point in points[:MOST_NAMED_POINTS]:
        nodes = "" if point["nodes"] is None else f", {_count(point['nodes'])}"
        yield f"{name} at {told_place(point['position'], summary)}{nodes}"
    if len(points) > MOST_NAMED_POINTS:
        yield f"and {len(points) - MOST_NAMED_POINTS} more interface points"


def _told_nodes(each: NodesRecord | PointRecord, summary: BodySummary) -> str:
    """Mean position and number of some nodes, in words."""
    unit = summary["units"]["position"]
    where = "nowhere" if each["position"] is None else f"{told_place(each['position'], summary)} {unit}"
    return where if each["nodes"] is None else f"{where}, {_count(each['nodes'])}"


def _told_inertia(inertia: float | list[list[float]]) -> str:
    if not isinstance(inertia, list):
        return f"{inertia:.6g}"
    pairs = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    return ", ".join(f"{name} {inertia[i][j]:.6g}" for name, (i, j) in pairs.items() if i == j or inertia[i][j])


def _count(nodes: int) -> str:
    return "1 node" if nodes == 1 else f"{nodes} nodes"


def told_place(position: Sequence[float], summary: BodySummary, digits: int = 6) -> str:
    """Coordinates in words, such as "(4, 0.5, 0.25)"; those far below the size of the body are 0."""
    inertia = summary["inertia"]
    moment = sum(inertia[k][k] for k in range(3)) / 2 if isinstance(inertia, list) else inertia
    least = ZERO_COORDINATE * sqrt(max(moment, 0.0) / summary["mass"])
    return f"({', '.join(f'{x if abs(x) > least else 0.0:.{digits}g}' for x in position)})"
