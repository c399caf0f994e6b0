"""Displacement and rotation of a marker."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np

from toolkit.components.joints.kernels.laws import angle_of
from toolkit.description.description import Quantity, Triple
from toolkit.foundation.errors import InputError
from toolkit.foundation.kernel import plain
from toolkit.foundation.kinematics.orientation import axes_along
from toolkit.responses.response import OnePoint, Partials, magnitude, refuse_axis
from toolkit.system.solution import MarkerStates, Solution

if TYPE_CHECKING:
    from toolkit.scene.resolution import ResolvedScene


class MarkerResponse(OnePoint):
    """Base of responses that follow from the pose of one point."""

    def at(self, solution: Solution, step: int) -> Partials:
        """Value and partial derivatives at one step."""
        return self.instants(solution)(step)

    @abstractmethod
    def instants(self, solution: Solution) -> Callable[[int], Partials]:
        """Value and partial derivatives, step by step, with what all steps need prepared once."""

    def pose(self, states: MarkerStates, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Pose (p,), 3 or 12 numbers, its derivatives by the coordinates (p, n_q) and by the design (p, n_x)."""
        system, state = states.system, states.at(q)
        marker, markers = system.numbering.marker((self.body, self.point)), system.plan.markers
        columns = slice(markers.start[marker], markers.start[marker + 1])
        size = state.y.shape[1]
        pose_q: np.ndarray = np.zeros((size, system.n_q), system.dtype)
        pose_q[:, markers.coordinate[columns]] = state.B[columns].T
        pose_x = np.zeros((size, system.n_x))
        for d in range(markers.design_start[marker], markers.design_start[marker + 1]):
            pose_x[:, markers.design_variable[d]] += np.real(state.y_x[d])
        return state.y[marker].copy(), pose_q, pose_x


class Rotation(MarkerResponse):
    """Rotation of a body at a point since the undeformed configuration, counter-clockwise positive; in space about an axis.

    In space it is atan2(n_2 . A n_1, n_1 . A n_1) in (-pi, pi] with the body's rotation matrix A and n_1, n_2 normal to the axis: the
    rotation itself, where the body turns about this axis alone.

    Attributes
    ----------
    axis
        Axis, of a spatial scene alone, of any length.
    """

    kind = "rotation"
    quantity = "angle"

    axis: Annotated[Triple | None, Quantity("none")] = None

    def check(self, scene: ResolvedScene) -> None:
        """Refuse an axis in the plane, and its absence in space.

        Raises
        ------
        InputError
            It is missing there, or given in the plane.
        """
        super().check(scene)
        refuse_axis(self.axis, scene, "rotation")

    def instants(self, solution: Solution) -> Callable[[int], Partials]:
        """Rotation angle of the marker and its partial derivatives, step by step."""
        states = MarkerStates(solution.system)
        return lambda step: self._angle(*self.pose(states, solution.q[step]))

    def _angle(self, pose: np.ndarray, pose_q: np.ndarray, pose_x: np.ndarray) -> Partials:
        if self.axis is None:
            return Partials(pose[2], q=pose_q[2], design=pose_x[2])
        axes = axes_along(self.axis)
        cosine, sine = np.kron(axes[:, 0], axes[:, 0]), np.kron(axes[:, 0], axes[:, 1])  # on the axes e_1, e_2, e_3 of the pose
        c, s = cosine @ pose[3:], sine @ pose[3:]
        weights = (c * sine - s * cosine) / (c * c + s * s)
        return Partials(plain(angle_of)(s, c), q=weights @ pose_q[3:], design=np.real(weights @ pose_x[3:]))


class Displacement(MarkerResponse):
    """Displacement of a point of a body since the undeformed configuration: one component, or its magnitude.

    Attributes
    ----------
    component
        One component, or the magnitude.
    """

    kind = "displacement"
    quantity = "length"

    component: Literal["x", "y", "z", "magnitude"]

    def check(self, scene: ResolvedScene) -> None:
        """Refuse a z component in a planar scene.

        Raises
        ------
        InputError
            A component that the scene does not have.
        """
        super().check(scene)
        if self.component not in (*scene.space.axes, "magnitude"):
            raise InputError('a scene of dimension 2 has no displacement along z; take "x", "y" or "magnitude".')

    def instants(self, solution: Solution) -> Callable[[int], Partials]:
        """Position of the marker minus the undeformed one, step by step; the undeformed one may depend on the design too."""
        system, d = solution.system, solution.system.scene.dimension
        states = MarkerStates(system)
        start, dstart = (item[: system.n_q] for item in system.undeformed())
        origin, origin_q, origin_x = self.pose(states, start)
        own = np.any(origin_q, axis=0)
        fixed_x = origin_x + np.real(origin_q[:, own]) @ dstart[own]

        def look(step: int) -> Partials:
            pose, pose_q, pose_x = self.pose(states, solution.q[step])
            move, move_q, move_x = (pose - origin)[:d], pose_q[:d], (pose_x - fixed_x)[:d]
            if self.component != "magnitude":
                row = "xyz".index(self.component)
                return Partials(move[row], q=move_q[row], design=move_x[row])
            length, direction = magnitude(move, lambda: np.real(move_q) @ solution.derivative("q")[step] + move_x)
            return Partials(length, q=direction @ move_q, design=direction @ move_x)

        return look
