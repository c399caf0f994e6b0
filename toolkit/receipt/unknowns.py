"""Unknowns of a scene: coordinates of its bodies, rows of its joints, and the matrix between them."""

from __future__ import annotations

import numpy as np

from toolkit.linear.sparse_analysis import LUPlan
from toolkit.receipt.everything import grounded_bodies
from toolkit.receipt.line import Line
from toolkit.receipt.terms import rigid_bodies
from toolkit.system import System


def coordinates(system: System) -> list[Line]:
    """Coordinates of each flexible body, and of all rigid ones."""
    scene, grounded, rigid = system.scene, grounded_bodies(system.scene), rigid_bodies(system)
    lines = [
        Line(
            name,
            len(body.coordinate_names(scene)),
            *((3, "grounded frame: it neither moves nor turns") if name in grounded else ()),
        )
        for name, body in scene.bodies.items()
        if name not in rigid
    ]
    return [*lines, Line(f"{len(rigid)} rigid", 3 * len(rigid))] if rigid else lines


def rows(system: System) -> list[Line]:
    """Constraint rows of the joints by their kind, and those that would hold a grounded frame if it could move."""
    joints = list(system.scene.joints.values())
    kinds = {
        kind: [len(joint.row_names) for joint in joints if joint.kind == kind] for kind in dict.fromkeys(j.kind for j in joints)
    }
    held = [Line(f"frame of {name}", 0, 3, "grounded frame: nothing has to hold it") for name in grounded_bodies(system.scene)]
    return [*(Line(f"{len(sizes)} {kind}", sum(sizes)) for kind, sizes in kinds.items()), *held]


def matrix(system: System) -> list[Line]:
    """Entries of the Jacobian and of its factors."""
    entries, stored, n = len(system.plan.indices), int(system.lu_plan.row_start[-1]), system.n
    return [
        Line("Jacobian", entries, n * n - entries, "entries that no part of the scene fills"),
        Line("its factors", stored, n * n - stored, "entries that elimination in this order leaves zero"),
    ]


def multiplications(plan: LUPlan) -> tuple[int, int]:
    """Multiplications of one factorization, and of one solution of the factored equations.

        factorization: sum_k u_k^2 + u_k
        solution:      sum_k 2 u_k + 1

    with u_k entries of U in row k beside the diagonal.
    """
    upper = plan.row_start[1:] - plan.diagonal - 1
    return int(np.sum(upper**2 + upper)), int(np.sum(2 * upper + 1))
