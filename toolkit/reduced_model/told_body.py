"""What a body is, in words: one line for the terminal after it was built, and a few lines for whoever looks into its file."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from math import sqrt
from typing import Any

import numpy as np

from toolkit.foundation.units import unit
from toolkit.reduced_model.composition import Composition, read_composition
from toolkit.reduced_model.model import ReducedModel
from toolkit.reduced_model.parts import SpatialInvariants, all_second_moments

ROUND_OFF = 1e-13
"""Part of the body's size, or of its inertia, below which a coordinate of the centre or a product of inertia is round-off."""
NOT_KEPT = (
    "The file of this model does not keep its nodes, elements, volume and groups; ffrf-preprocess --force builds one that does."
)


def body_summary(model: ReducedModel) -> dict[str, Any]:
    """Summary of a reduced model's body at its nominal design, in the units of its system.

    Returns
    -------
    summary
        `mass`, `centre`, `inertia` (about the centre; a tensor in space, a number in the plane), `volume`, `nodes`, `elements` by kind,
        `units`, `interface_points` and `groups` with `position` and number of `nodes`, `clamp`, concentrated `masses`, `left_out`,
        `remarks`, and `not_listed`: how many more groups and so on there are. None is what is not known.
    """
    kept = read_composition(model.composition, model.dimension)
    centre, inertia = centre_and_inertia(model)
    length, mass = unit(model.units, "length"), unit(model.units, "mass")
    return {
        "mass": float(np.real(model.invariants.mass)),
        "centre": centre.tolist(),
        "inertia": inertia.tolist(),
        "volume": kept.volume,
        "nodes": kept.nodes,
        "elements": dict(kept.elements) if model.composition else None,
        "units": {
            "mass": mass,
            "centre": length,
            "inertia": f"{mass} {length}^2",
            "volume": f"{length}^3",
            "position": length,
        },
        "interface_points": _interface_points(model, kept),
        "clamp": kept.clamp and kept.clamp._asdict(),
        "groups": {name: each._asdict() for name, each in kept.groups.items()},
        "masses": [each._asdict() for each in kept.masses],
        "left_out": [each._asdict() for each in kept.left_out],
        "remarks": [*kept.remarks, *([] if model.composition else [NOT_KEPT])],
        "not_listed": dict(kept.not_listed),
    }


def centre_and_inertia(model: ReducedModel) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass (d,), and the inertia about it: (3, 3) in space, () in the plane."""
    inv, mass = model.invariants, float(np.real(model.invariants.mass))
    centre = np.real(inv.first_moment[:, 0]) / mass
    if isinstance(inv, SpatialInvariants):
        moments = np.real(all_second_moments(inv.second_moment)[:, :, 0, 0]) - mass * np.outer(centre, centre)
        inertia = np.trace(moments) * np.eye(3) - moments
        radius = np.sqrt(max(np.trace(moments), 0.0) / mass)
    else:
        inertia = np.real(inv.inertia[0, 0]) - mass * centre @ centre
        radius = np.sqrt(max(float(inertia), 0.0) / mass)
    return _without_round_off(centre, radius + np.abs(centre).max()), _without_round_off(inertia, np.abs(inertia).max())


def _without_round_off(numbers: np.ndarray, scale: float) -> np.ndarray:
    return np.where(np.abs(numbers) > ROUND_OFF * scale, numbers, 0.0)


def _interface_points(model: ReducedModel, kept: Composition) -> dict[str, Any]:
    places = {name: np.real(point.position[0, :, 0]).tolist() for name, point in (model.interfaces or {}).items()}
    return {name: {"position": place, "nodes": kept.interface_points.get(name)} for name, place in places.items()}


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
NOWHERE_ELSE = 1e-5
"""Part of the body's radius of gyration below which a coordinate is told as zero."""
POINTS_IN_LINE = 4
"""Interface points that the one line names; the others are counted."""


def body_line(name: str, summary: Mapping[str, Any]) -> str:
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


def body_lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """Body in several lines with everything that is known, one item a line."""
    units = summary["units"]
    yield f"mass: {summary['mass']:.6g} {units['mass']}"
    yield f"centre: {told_place(summary['centre'], summary)} {units['centre']}"
    yield f"inertia about the centre: {_told_inertia(summary['inertia'])} {units['inertia']}"
    yield "volume: " + ("not known" if summary["volume"] is None else f"{summary['volume']:.6g} {units['volume']}")
    yield f"elements: {told_elements(summary) or 'not known'}"
    if summary["clamp"]:
        yield f"clamp: {_told_nodes(summary['clamp'], summary)}"
    for kind, words in (("interface_points", "interface point"), ("groups", "group")):
        yield from (f"{words} {name}: {_told_nodes(each, summary)}" for name, each in summary[kind].items())
    for each in summary["masses"]:
        place = f"{told_place(each['position'], summary)} {units['position']}"
        yield f"mass of {each['mass']:.6g} {units['mass']} at {place}, by {each['source']}"
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
    """Entries of a mesh file that are not part of the body, in words: how many of what, and why."""
    return ", ".join(f"{each['number']} {each['what']} ({each['why']})" for each in left_out)


def _kind(kind: str, number: int) -> str:
    """Number and kind of elements in words, for example "4 hexahedra", or "11 hexahedra with 20 nodes each"."""
    found = re.fullmatch(r"([a-z]+)(\d*)", kind)
    if found is None or found[1] not in NAMES:
        return f"{number} {kind}"
    each = f" with {found[2]} nodes{' each' * (number != 1)}" if found[2] else ""
    return f"{number} {NAMES[found[1]][number != 1]}{each}"


def _points_in_line(summary: Mapping[str, Any]) -> Iterator[str]:
    points = list(summary["interface_points"].items())
    for name, point in points[:POINTS_IN_LINE]:
        nodes = "" if point["nodes"] is None else f", {_count(point['nodes'])}"
        yield f"{name} at {told_place(point['position'], summary)}{nodes}"
    if len(points) > POINTS_IN_LINE:
        yield f"and {len(points) - POINTS_IN_LINE} more interface points"


def _told_nodes(each: Mapping[str, Any], summary: Mapping[str, Any]) -> str:
    """Mean position and number of some nodes, in words."""
    unit = summary["units"]["position"]
    where = "nowhere" if each["position"] is None else f"{told_place(each['position'], summary)} {unit}"
    return where if each["nodes"] is None else f"{where}, {_count(each['nodes'])}"


def _told_inertia(inertia: Any) -> str:
    if not isinstance(inertia, list):
        return f"{inertia:.6g}"
    pairs = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    return ", ".join(f"{name} {inertia[i][j]:.6g}" for name, (i, j) in pairs.items() if i == j or inertia[i][j])


def _count(nodes: int) -> str:
    return "1 node" if nodes == 1 else f"{nodes} nodes"


def told_place(position: Sequence[float], summary: Mapping[str, Any], digits: int = 6) -> str:
    """Coordinates in words, such as "(4, 0.5, 0.25)"; those far below the size of the body are 0."""
    inertia = summary["inertia"]
    moment = sum(inertia[k][k] for k in range(3)) / 2 if isinstance(inertia, list) else inertia
    least = NOWHERE_ELSE * sqrt(max(moment, 0.0) / summary["mass"])
    return f"({', '.join(f'{x if abs(x) > least else 0.0:.{digits}g}' for x in position)})"
