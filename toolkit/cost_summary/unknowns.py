"""Unknowns of a scene: coordinates of its bodies, rows of its joints, and the matrix between them."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.body import Body
from toolkit.cost_summary.everything import grounded_bodies
from toolkit.cost_summary.line import Line
from toolkit.cost_summary.terms import frame_of, rigid_bodies
from toolkit.joints.joint import Joint
from toolkit.joints.rigid_joint import Tie
from toolkit.linear.sparse_analysis import LUPlan
from toolkit.scene.space import SPACES
from toolkit.system.flexible_bodies import deforming
from toolkit.system.system import System

IDLE = {
    "grounded": "it neither moves nor turns",
    "translating": "it does not turn",
    "turning": "it turns about one axis and does not move",
}
"""Reasons why frames of fewer coordinates lack the others: what they do not do."""


def coordinates(system: System) -> list[Line]:
    """Lines for the coordinates of each flexible body, and of all rigid ones."""
    scene, rigid = system.scene, rigid_bodies(system)
    bodies = deforming(scene)
    lines = [Line(name, len(body.coordinate_names(scene)), *_missing(body)) for name, body in bodies.items()]
    own = [scene.bodies[name] for name in rigid]
    kept, most = sum(body.frame_size for body in own), scene.space.frame_size * len(own)
    why = "frames that do not move, or do not turn about every axis" if kept < most else ""
    lines += [Line(f"{len(rigid)} rigid", kept, most - kept, why)] if rigid else []
    states = len(system.numbering.states)
    return [*lines, Line(f"{states} states of loads", states)] if states else lines


def _missing(body: Body) -> tuple[int, str]:
    """Number of coordinates that a flexible body's frame does not have, and why."""
    missing = SPACES[body.dimension].frame_size - body.frame_size
    return (missing, f"{frame_of(body)} frame: {IDLE[frame_of(body)]}") if missing else (0, "")


def rows(system: System) -> list[Line]:
    """Lines for the constraint rows of the joints by kind, and for those that would hold a grounded frame if it could move."""
    joints = list(system.scene.joints.values())
    kinds = {
        kind: [len(joint.row_names) for joint in joints if _kind(joint) == kind] for kind in dict.fromkeys(map(_kind, joints))
    }
    whole = system.scene.space.frame_size  # rows that hold a frame, a quaternion's length among them
    held = [
        Line(f"frame of {name}", 0, whole, "grounded frame: nothing has to hold it") for name in grounded_bodies(system.scene)
    ]
    lengths = len(system.numbering.length)
    quaternions = [Line(f"{lengths} lengths of quaternions", lengths)] if lengths else []
    return [*(Line(f"{len(sizes)} {kind}", sum(sizes)) for kind, sizes in kinds.items()), *quaternions, *held]


def _kind(joint: Joint) -> str:
    return "between parts of bodies" if isinstance(joint, Tie) else joint.kind


def matrix(system: System) -> list[Line]:
    """Lines for the entries of the Jacobian and of its factors."""
    entries, stored, n = len(system.plan.indices), int(system.lu_plan.row_start[-1]), system.n
    return [
        Line("Jacobian", entries, n * n - entries, "entries that no part of the scene fills"),
        Line("its factors", stored, n * n - stored, "entries that elimination in this order leaves zero"),
    ]


def multiplications(plan: LUPlan) -> tuple[int, int]:
    """Number of multiplications of one factorization, and of one solution of the factored equations.

        factorization: sum_k u_k^2 + u_k
        solution:      sum_k 2 u_k + 1

    with u_k entries of U in row k beside the diagonal.
    """
    upper = plan.row_start[1:] - plan.diagonal - 1
    return int(np.sum(upper**2 + upper)), int(np.sum(2 * upper + 1))
