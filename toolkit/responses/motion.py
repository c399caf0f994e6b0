"""Displacement and rotation of a marker."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from toolkit.bodies.poses import update_pose_designs, update_poses
from toolkit.equations import allocate_work
from toolkit.responses.instant import Instant, magnitude
from toolkit.responses.response import Partials
from toolkit.solution import Solution
from toolkit.system import System


class MarkerResponse(Instant):
    """Base of responses that look at a point of a body.

    Attributes
    ----------
    body
        Name of the body.
    point
        Name of the point on it.
    """

    body: str
    point: str

    def markers(self) -> tuple[tuple[str, str], ...]:
        """The point on the body."""
        return ((self.body, self.point),)

    def pose(self, system: System, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Pose (3,), its derivatives by the coordinates (3, n_q) and by the design (3, n_x)."""
        marker, state, markers = system.numbering.marker((self.body, self.point)), marker_states(system, q), system.plan.markers
        columns = slice(markers.start[marker], markers.start[marker + 1])
        pose_q: np.ndarray = np.zeros((3, system.n_q), system.dtype)
        pose_q[:, markers.coordinate[columns]] = state.B[columns].T
        pose_x = np.zeros((3, system.n_x))
        for d in range(markers.design_start[marker], markers.design_start[marker + 1]):
            pose_x[:, markers.design_variable[d]] += np.real(state.y_x[d])
        return state.y[marker], pose_q, pose_x


def marker_states(system: System, q: np.ndarray) -> Any:
    """All markers at coordinates (n_q,), at rest."""
    work, markers = allocate_work(system.plan, system.dtype), system.plan.markers
    rest: np.ndarray = np.zeros(system.n, system.dtype)
    padded = np.concatenate([q, rest[system.n_q :]])
    for function in (update_poses, update_pose_designs):
        system.run(function, markers.plane, markers.frames, markers, work.markers, padded, rest, rest, work.scratch)
    return work.markers


class Rotation(MarkerResponse):
    """Rotation of a body at a point since the undeformed configuration, counter-clockwise positive."""

    kind = "rotation"
    quantity = "angle"

    def at(self, solution: Solution, step: int) -> Partials:
        """The angle of the marker."""
        pose, pose_q, pose_x = self.pose(solution.system, solution.q[step])
        return Partials(pose[2], q=pose_q[2], design=pose_x[2])


class Displacement(MarkerResponse):
    """Displacement of a point of a body since the undeformed configuration: one component, or its magnitude.

    Attributes
    ----------
    component
        One component, or the magnitude.
    """

    kind = "displacement"
    quantity = "length"

    component: Literal["x", "y", "magnitude"]

    def at(self, solution: Solution, step: int) -> Partials:
        """Position of the marker minus the undeformed one, which may follow the design too."""
        system = solution.system
        start, _, dstart, _ = (item[: system.n_q] for item in system.start())
        pose, pose_q, pose_x = self.pose(system, solution.q[step])
        origin, origin_q, origin_x = self.pose(system, start)
        move, move_q, move_x = (pose - origin)[:2], pose_q[:2], (pose_x - origin_x - np.real(origin_q) @ dstart)[:2]
        if self.component != "magnitude":
            row = "xy".index(self.component)
            return Partials(move[row], q=move_q[row], design=move_x[row])
        length, direction = magnitude(move, lambda: np.real(move_q) @ solution.derivative("q")[step] + move_x)
        return Partials(length, q=direction @ move_q, design=direction @ move_x)
