"""Names in a scene: each is legal, and each that is used exists."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from toolkit.bodies.model_body import ModelBody
from toolkit.description.design import BodyPoint, DesignEntry
from toolkit.foundation.errors import SHORT, InputError, meant
from toolkit.loads.pressure import Pressure
from toolkit.markers.component import Component

GROUPS = ("points", "bodies", "joints", "loads", "responses")
"""Tables of names."""
PLURAL = {"body": "bodies", "point": "points", "joint": "joints", "load": "loads"}


def check_names(
    points: Mapping[str, Any], bodies: Mapping[str, Any], joints: Mapping[str, Any], loads: Mapping[str, Any], responses: Mapping
) -> None:
    """Check all names of a scene.

    Raises
    ------
    InputError
        A name is not legal, or something names a body, point or joint that does not exist.
    """
    groups = {"points": points, "bodies": bodies, "joints": joints, "loads": loads, "responses": responses}
    for group, items in groups.items():
        for name in items:
            _legal(group, name)
    existing = {"body": (*bodies, "ground"), "point": points, "joint": joints, "load": loads}
    for group in ("joints", "loads"):
        for name, component in groups[group].items():
            if isinstance(component, Component):
                for body, point in component.grips:
                    known(body, existing["body"], f"{group}.{name}", "body")
                    known(point, points, f"{group}.{name}", "point")
    for name, load in loads.items():
        if isinstance(load, Pressure):
            known(load.body, bodies, f"loads.{name}", "body")
            if not isinstance(bodies[load.body], ModelBody):
                raise InputError(f"loads.{name} presses on body {load.body!r}, which is not flexible and has no named surfaces.")
    for name, owner in bodies.items():
        for point in owner.named_points():
            known(point, points, f"bodies.{name}", "point")
        for key, wishes in owner.deflected.items() if isinstance(owner, ModelBody) else ():
            for point in wishes:
                known(point, points, f"bodies.{name}.{key}", "point")
    for name, written in points.items():
        if isinstance(written, BodyPoint):
            known(written.body, bodies, f"points.{name}", "body")
    for name, response in responses.items():
        for kind, names in existing.items():
            for used in _named(response, kind):
                known(used, names, f"responses.{name}", kind)


def check_design_names(design: Mapping[str, DesignEntry], where: str = "design") -> None:
    """Check that no design variable is called like a number that it leaves alone: who set that number would move others.

    Raises
    ------
    InputError
        Names the variable.
    """
    for name, entry in design.items():
        own = (entry,) if isinstance(entry, str) else entry.of
        if name.partition(".")[0] in (*GROUPS, "solver") and "." in name and name not in own:
            raise InputError(
                f"{where}.{name}: that is the path of a number, and the variable drives {', '.join(own)} instead. Give it a name without "
                "dots."
            )


def _named(response: Any, kind: str) -> list[str]:
    """Names that a response, or the one that it looks at over time, gives under the word for one of a kind or for several."""
    found: list[str] = []
    for each in (response, getattr(response, "of", None)):
        for value in (getattr(each, kind, None), getattr(each, PLURAL[kind], None)):
            found += [value] if isinstance(value, str) else value if isinstance(value, tuple) else ()
    return found


def check_dimension(dimension: int, points: Mapping[str, Any], groups: Mapping[str, Mapping[str, Any]]) -> None:
    """Refuse a planar scene with what belongs to space, and the reverse.

    Raises
    ------
    InputError
        Names the point or component.
    """
    for name, point in points.items():
        if not isinstance(point, BodyPoint) and len(point.position()) != dimension:
            raise InputError(
                f"points.{name} has {len(point.position())} coordinates; a scene of dimension {dimension} has {dimension}."
            )
    for group, items in groups.items():
        for name, item in items.items():
            if item.dimension != dimension:
                raise InputError(f"{group}.{name} is for dimension {item.dimension}, the scene has dimension {dimension}.")


def known(name: str, existing: Iterable[str], user: str, kind: str) -> None:
    """Refuse a name that does not exist, and list those that do.

    Raises
    ------
    InputError
        The name does not exist.
    """
    if name not in existing:
        raise InputError(
            f"{user} names {kind} {name!r}, which does not exist{meant(name, existing)}; {PLURAL[kind]} of the scene: "
            f"{', '.join(existing) or 'none'}."
        )


def _legal(group: str, name: str) -> None:
    if set(name) & set("./\0") or not name.strip():
        raise InputError(
            f"{group}.{SHORT.repr(name)} is no legal name: dots and slashes separate the parts of a path. Use letters, digits and _."
        )
    if group == "bodies" and name == "ground":
        raise InputError(
            "a body cannot be called 'ground': that is the inertial frame, which is always there. Choose another name."
        )
