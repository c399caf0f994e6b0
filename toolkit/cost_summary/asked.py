"""Requests to a scene: derivative blocks of the variables, fields of the responses, points that are gripped."""

from __future__ import annotations

from types import UnionType

import numpy as np

from toolkit.bodies.body import CENTRE
from toolkit.bodies.model_body import ModelBody
from toolkit.cost_summary.line import Line
from toolkit.cost_summary.terms import rigid_bodies
from toolkit.responses.shape_error import ShapeResponse
from toolkit.responses.stress.local_stress import LocalStress
from toolkit.responses.stress.stress import StressResponse
from toolkit.scene.scene import Scene
from toolkit.sensitivity.preparation import responses_of
from toolkit.system.system import System

MOST_NAMES = 12
"""More variables than this are counted together."""


def derivative_blocks(system: System, scene: Scene) -> list[Line]:
    """Rows of the residual that each variable moves, and how many numbers of the scene, as it was written, have no block."""
    moved = np.bincount(system.plan.touched_variable, minlength=system.n_x)
    blocks = [Line(each.name, int(count)) for each, count in zip(system.design, moved, strict=True)]
    if len(blocks) > MOST_NAMES:
        blocks = [Line(f"{len(blocks)} variables", int(moved.sum()))]
    paths = {path for each in system.design for path in each.paths}
    others = len([path for path in scene.available_paths() if path not in paths])
    return [*blocks, Line("other numbers of the scene", 0, others, "no derivative by them was asked for")]


def fields(system: System) -> list[Line]:
    """Points of every flexible body where stress and distance to a target are computed."""
    found = []
    for name, body in system.scene.bodies.items():
        if isinstance(body, ModelBody):
            points = len(system.scene.model(body.model).invariants.stress_operator)
            stress, shape = asking(system.scene, StressResponse | LocalStress, name), asking(system.scene, ShapeResponse, name)
            found.append(_field(f"stress of {name}", points, stress))
            if shape:
                target = system.scene.model(body.model, "shape").shape
                found.append(_field(f"distance of {name} to its target", 0 if target is None else len(target.target), shape))
            else:
                found.append(Line(f"distance of {name} to its target", 0, 0, "no response asks for it"))
    return found


def markers(system: System) -> list[Line]:
    """Points that a joint, a load or a response looks at, and interface points that none does."""
    found, rigid = [], rigid_bodies(system)
    for name, body in system.scene.all_bodies().items():
        used = {point for owner, point, *_ in system.numbering.markers if owner == name}
        known = (
            (system.scene.model(body.model).interfaces or {})
            if name in system.scene.bodies and isinstance(body, ModelBody)
            else {}
        )
        idle = set(known) - {getattr(system.scene.interface(point), "interface", "") for point in used if point != CENTRE}
        if name not in rigid:
            found.append(Line(name, len(used), len(idle), f"nothing looks at {', '.join(sorted(idle))}" if idle else ""))
    count = len([1 for owner, *_ in system.numbering.markers if owner in rigid])
    return [*found, Line(f"{len(rigid)} rigid", count)] if rigid else found


def asking(scene: Scene, kind: type | UnionType, body: str) -> list[str]:
    """Responses of a kind, or made of one, that look at a body."""
    parts = {name: (each, getattr(each, "of", None)) for name, each in responses_of(scene).items()}
    return [
        name
        for name, both in parts.items()
        if any(isinstance(each, kind) and getattr(each, "body", None) == body for each in both)
    ]


def _field(what: str, points: int, asked: list[str]) -> Line:
    return Line(what, points, 0, f"for {', '.join(asked)}") if asked else Line(what, 0, points, "no response asks for it")
