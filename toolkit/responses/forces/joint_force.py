"""Force and torque that a joint exerts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Literal

import numpy as np

from toolkit.equations.equations import allocate_work
from toolkit.foundation.errors import InputError
from toolkit.joints.kernels.planar_joint import change_number, evaluate_planar_joint
from toolkit.joints.kernels.records import CURVED, DESIGN
from toolkit.responses.forces.least_squares_forces import least_squares_forces, lengths_of_joints
from toolkit.responses.forces.spatial_joint_force import Force, SpatialJointForce
from toolkit.responses.instant import Instant, magnitude
from toolkit.responses.response import Partials
from toolkit.scene.space import PLANE, SPACE, Space
from toolkit.system.marker_states import MarkerStates
from toolkit.system.solution import Solution
from toolkit.system.system import System

Wrench = Callable[[np.ndarray, np.ndarray], Force]
"""Force and torque of a joint by coordinates (n_q,) and multipliers (n_lam,)."""


class JointForce(Instant):
    """Force F = - g_y^T lam of a joint on its body a, in global axes: one component, its magnitude, or the torque about the joint's point.

    Where joints repeat each other and the scene asks for it (`solver.redundant`), it is that of least squares.

    Attributes
    ----------
    joint
        Name of the joint.
    component
        What of the force: one component, its magnitude, or the torque; in space torque-x, torque-y and torque-z.
    """

    kind = "joint-force"
    quantity = "force"

    joint: str
    component: Literal["x", "y", "z", "magnitude", "torque", "torque-x", "torque-y", "torque-z"]

    @property
    def unit_quantity(self) -> str:
        """Name of the physical quantity: "torque" for a torque component, otherwise "force"."""
        return "torque" if self.component.startswith("torque") else "force"

    def check(self, scene: Any) -> None:
        """Refuse a component that joint forces do not have in the scene's space.

        Raises
        ------
        InputError
            It does not; names those that do.
        """
        super().check(scene)
        known = (*scene.space.wrench, "magnitude")
        if self.component not in known:
            raise InputError(
                f"a joint force in a scene of dimension {scene.dimension} has no {self.component!r}; available: {', '.join(known)}."
            )

    def at(self, solution: Solution, step: int) -> Partials:
        """Force or torque component at a step, and its derivatives by coordinates, multipliers and design."""
        return self.instants(solution)(step)

    def instants(self, solution: Solution) -> Callable[[int], Partials]:
        """Force or torque component with its derivatives, step by step."""
        wrench = self.wrench(solution.system)
        return lambda step: self._component(solution, step, wrench(solution.q[step], solution.multipliers[step]))

    def _component(self, solution: Solution, step: int, found: Force) -> Partials:
        force, force_q, force_lam, force_x = found
        d = solution.system.scene.dimension
        if self.component == "magnitude":

            def change() -> np.ndarray:
                dq, dlam = solution.derivative("q")[step], solution.derivative("multipliers")[step]
                return (np.real(force_q) @ dq + np.real(force_lam) @ dlam + force_x)[:d]

            size, direction = magnitude(force[:d], change)
            weights = np.append(direction, np.zeros(len(force) - d))
            return Partials(size, q=weights @ force_q, multipliers=weights @ force_lam, design=weights @ force_x)
        k = solution.system.scene.space.wrench.index(self.component)
        return Partials(force[k], q=force_q[k], multipliers=force_lam[k], design=force_x[k])

    def wrench(self, system: System) -> Wrench:
        """Function that evaluates the joint's force and torque, and their derivatives, at coordinates and multipliers."""
        of_joint, j = _WRENCH[system.scene.space], list(system.scene.joints).index(self.joint)
        if not len(system.plan.dropped):
            return of_joint(system, j)
        return partial(_of_least_squares, system, [of_joint(system, k) for k in range(len(system.scene.joints))], j)


def _of_least_squares(system: System, of_joints: Sequence[Wrench], j: int, q: np.ndarray, lam: np.ndarray) -> Force:
    """Force and torque of joint number j with least-squares multipliers, and their derivatives."""
    forces = least_squares_forces(system, q, lam, partial(_wrenches, system, of_joints, q))
    value, by_q, by_lam, by_x = of_joints[j](q, forces.value)
    return value, by_q + by_lam @ forces.by_q, by_lam @ forces.by_lam, by_x + np.real(by_lam @ forces.by_x)


def _wrenches(system: System, of_joints: Sequence[Wrench], q: np.ndarray, lam: np.ndarray) -> tuple[np.ndarray, ...]:
    """Forces, times the size of what its joints connect, and torques of all joints, with their derivatives."""
    d, found = system.scene.dimension, [of_joint(q, lam) for of_joint in of_joints]
    lengths, lengths_x = lengths_of_joints(system)
    force = np.concatenate([np.arange(len(each[0])) < d for each in found])
    joint = np.repeat(np.arange(len(found)), [len(each[0]) for each in found])
    scale, scale_x = np.where(force, lengths[joint], 1.0), np.where(force[:, None], lengths_x[joint], 0.0)
    value, by_q, by_lam, by_x = (np.concatenate([each[k] for each in found]) for k in range(4))
    column = scale[:, None]
    return scale * value, column * by_q, column * by_lam, column * by_x + scale_x * value[:, None]


class PlanarJointForce:
    """Force (f_x, f_y) and torque of planar joint j, with derivatives (3, n_q), (3, n_lam), (3, n_x), one state at a time."""

    def __init__(self, system: System, j: int) -> None:
        self.system, self.j, self._markers = system, j, MarkerStates(system)
        self._joint = allocate_work(system.plan, system.dtype).joint
        self._acc: np.ndarray = np.zeros(system.n, system.dtype)
        given = system.functions[0], system.plan.joints, j, self._markers.found, self._acc, self._joint
        self._evaluate = system.prepared(evaluate_planar_joint, *given)

    def __call__(self, q: np.ndarray, lam: np.ndarray) -> Force:
        """Force and torque with their derivatives at coordinates (n_q,) and multipliers (n_lam,)."""
        system, j, joint, joints = self.system, self.j, self._joint, self.system.plan.joints
        state = self._markers.at(q)
        self._acc[system.n_q :] = lam
        self._evaluate()
        force: np.ndarray = -joint.force[0, :3]
        rows = slice(joints.row[j] - system.n_q, joints.row[j] - system.n_q + joints.n_rows[j])
        force_lam: np.ndarray = np.zeros((3, system.n - system.n_q), system.dtype)
        force_lam[:, rows] = -joint.slope[: joints.n_rows[j], 0, :3].T
        force_q: np.ndarray = np.zeros((3, system.n_q), system.dtype)
        force_x = np.zeros((3, system.n_x))
        if joints.of[j, CURVED]:
            self._add_by_pose(state, force_q, force_x)
        for d in range(joints.of[j, DESIGN], joints.of[j, DESIGN + 1]):
            of_row = self._acc[joints.row[j] + joints.design[d, 1]]
            system.run(change_number, joints, j, d, of_row, np.zeros(3), joint)
            force_x[:, joints.design[d, 0]] -= np.real(joint.force[1, :3])
        return force, force_q, force_lam, force_x

    def _add_by_pose(self, state: Any, force_q: np.ndarray, force_x: np.ndarray) -> None:
        """Add the force's derivatives through the poses of both markers."""
        markers, stiffness = self.system.plan.markers, -self._joint.stiffness[:3]
        for side in range(2):
            m = self.system.plan.joints.marker[self.j, side]
            by_pose = stiffness[:, 3 * side : 3 * side + 3]
            for k in range(markers.start[m], markers.start[m + 1]):
                force_q[:, markers.coordinate[k]] += by_pose @ state.B[k]
            for d in range(markers.design_start[m], markers.design_start[m + 1]):
                force_x[:, markers.design_variable[d]] += np.real(by_pose @ state.y_x[d])


_WRENCH: dict[Space, Callable[[System, int], Wrench]] = {PLANE: PlanarJointForce, SPACE: SpatialJointForce}
"""Force and torque of a joint by its number."""
