"""Displacement and rotation of a marker."""

from __future__ import annotations

from typing import Literal

import numpy as np

from toolkit.bodies.marker_design import update_marker_designs
from toolkit.bodies.marker_kernel import MarkerState, update_markers
from toolkit.compilation.quantities import STEP
from toolkit.equations import allocate_work
from toolkit.responses.instant import Instant
from toolkit.responses.response import Partials
from toolkit.solution import Solution


class MarkerResponse(Instant):
    """Base of responses that look at a point of a body."""

    body: str
    point: str

    def markers(self) -> tuple[tuple[str, str], ...]:
        """The point on the body."""
        return ((self.body, self.point),)

    def pose(self, solution: Solution, step: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Pose (3,), its derivatives by the coordinates (3, n_q) and by the design (3, n_x)."""
        system, marker = solution.system, solution.system.numbering.marker((self.body, self.point))
        state = marker_states(solution, step)
        markers = system.plan.markers
        columns = slice(markers.start[marker], markers.start[marker + 1])
        pose_q: np.ndarray = np.zeros((3, system.n_q), system.dtype)
        pose_q[:, markers.coordinate[columns]] = state.B[columns].T
        pose_x = np.zeros((3, system.n_x))
        for d in range(markers.design_start[marker], markers.design_start[marker + 1]):
            pose_x[:, markers.design_variable[d]] += np.real(state.y_x[d])
        return state.y[marker], pose_q, pose_x


def marker_states(solution: Solution, step: int) -> MarkerState:
    """All markers at one step of a solution, at rest."""
    system = solution.system
    work = allocate_work(system.plan, system.dtype)
    rest: np.ndarray = np.zeros(system.n, system.dtype)
    q = np.concatenate([solution.q[step], rest[system.n_q :]])
    for function in (update_markers, update_marker_designs):
        system.run(function, system.plan.markers, work.markers, q, rest, rest, work.scratch)
    return work.markers


class Rotation(MarkerResponse):
    """Rotation of a body at a point since the undeformed configuration, counter-clockwise positive."""

    kind = "rotation"
    quantity = "angle"

    def at(self, solution: Solution, step: int) -> Partials:
        """The angle of the marker."""
        pose, pose_q, pose_x = self.pose(solution, step)
        return Partials(pose[2], q=pose_q[2], design=pose_x[2])


class Displacement(MarkerResponse):
    """Displacement of a point of a body since the undeformed configuration: one component, or its magnitude."""

    kind = "displacement"
    quantity = "length"

    component: Literal["x", "y", "magnitude"]

    def at(self, solution: Solution, step: int) -> Partials:
        """Position of the marker minus the undeformed position of the point."""
        pose, pose_q, pose_x = self.pose(solution, step)
        scene = solution.system.scene
        move, move_x = pose[:2] - scene.position(self.point), pose_x[:2].copy()
        for x, variable in enumerate(solution.system.design):
            stepped = scene.with_number(variable.path, scene.number(variable.path) + 1j * STEP)
            move_x[:, x] -= np.imag(stepped.position(self.point)) / STEP
        if self.component != "magnitude":
            row = "xy".index(self.component)
            return Partials(move[row], q=pose_q[row], design=move_x[row])
        length = np.sqrt(move @ move)
        direction = move / length if length.real != 0 else np.full(2, np.nan)
        return Partials(length, q=direction @ pose_q[:2], design=direction @ move_x)
