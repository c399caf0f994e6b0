"""Force and torque that a joint exerts."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Literal

import numpy as np

from toolkit.equations.equations import allocate_work
from toolkit.foundation.errors import InputError
from toolkit.joints.kernels.planar.joint_kernel import change_number, evaluate_planar_joint
from toolkit.joints.kernels.records import CURVED, DESIGN
from toolkit.responses.forces.least_squares_forces import least_squares_forces, lengths_of_joints
from toolkit.responses.forces.spatial_joint_force import spatial_joint_force
from toolkit.responses.instant import Instant, magnitude
from toolkit.responses.response import Partials
from toolkit.scene.space import PLANE, SPACE, Space
from toolkit.system.marker_states import marker_states
from toolkit.system.solution import Solution
from toolkit.system.system import System


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
        """A torque has another unit than a force."""
        return "torque" if self.component.startswith("torque") else "force"

    def check(self, scene: Any) -> None:
        """The component exists in the scene's space.

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
        """Value, and derivatives by coordinates, multipliers and design."""
        force, force_q, force_lam, force_x = self.force(solution, step)
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

    def force(self, solution: Solution, step: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Its components and their derivatives by q, by the multipliers and by the design."""
        system, q = solution.system, solution.q[step]
        j = list(system.scene.joints).index(self.joint)
        of_joint = _WRENCH[system.scene.space]
        if not len(system.plan.dropped):
            return of_joint(system, j, q, solution.multipliers[step])
        forces = least_squares_forces(system, q, solution.multipliers[step], partial(_wrenches, system, q))
        value, by_q, by_lam, by_x = of_joint(system, j, q, forces.value)
        return value, by_q + by_lam @ forces.by_q, by_lam @ forces.by_lam, by_x + np.real(by_lam @ forces.by_x)


def _wrenches(system: System, q: np.ndarray, lam: np.ndarray) -> tuple[np.ndarray, ...]:
    """Forces, times the size of what its joints connect, and torques of all joints, with their derivatives."""
    of_joint, d = _WRENCH[system.scene.space], system.scene.dimension
    found = [of_joint(system, j, q, lam) for j in range(len(system.scene.joints))]
    lengths, lengths_x = lengths_of_joints(system)
    force = np.concatenate([np.arange(len(each[0])) < d for each in found])
    joint = np.repeat(np.arange(len(found)), [len(each[0]) for each in found])
    scale, scale_x = np.where(force, lengths[joint], 1.0), np.where(force[:, None], lengths_x[joint], 0.0)
    value, by_q, by_lam, by_x = (np.concatenate([each[k] for each in found]) for k in range(4))
    column = scale[:, None]
    return scale * value, column * by_q, column * by_lam, column * by_x + scale_x * value[:, None]


def _planar_force(
    system: System, j: int, q: np.ndarray, lam: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(f_x, f_y, torque) of joint number j and its derivatives (3, n_q), (3, n_lam), (3, n_x)."""
    plan = system.plan
    work, markers, state = allocate_work(plan, system.dtype), plan.markers, marker_states(system, q)
    acc: np.ndarray = np.concatenate([np.zeros(system.n_q, system.dtype), lam])
    system.run(evaluate_planar_joint, system.functions[0], plan.joints, j, state, acc, work.joint)
    rows = slice(plan.joints.row[j] - system.n_q, plan.joints.row[j] - system.n_q + plan.joints.n_rows[j])
    force_lam: np.ndarray = np.zeros((3, system.n - system.n_q), system.dtype)
    force_lam[:, rows] = -work.joint.slope[: plan.joints.n_rows[j], 0, :3].T
    force_q: np.ndarray = np.zeros((3, system.n_q), system.dtype)
    force_x = np.zeros((3, system.n_x))
    stiffness = -work.joint.stiffness[:3] if plan.joints.of[j, CURVED] else 0 * work.joint.stiffness[:3]
    for side in range(2):
        m = plan.joints.marker[j, side]
        by_pose = stiffness[:, 3 * side : 3 * side + 3]
        for k in range(markers.start[m], markers.start[m + 1]):
            force_q[:, markers.coordinate[k]] += by_pose @ state.B[k]
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            force_x[:, markers.design_variable[d]] += np.real(by_pose @ state.y_x[d])
    for d in range(plan.joints.of[j, DESIGN], plan.joints.of[j, DESIGN + 1]):
        of_row = acc[plan.joints.row[j] + plan.joints.design[d, 1]]
        system.run(change_number, plan.joints, j, d, of_row, np.zeros(3), work.joint)
        force_x[:, plan.joints.design[d, 0]] -= np.real(work.joint.force[1, :3])
    return -work.joint.force[0, :3], force_q, force_lam, force_x


Wrench = Callable[[System, int, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]
_WRENCH: dict[Space, Wrench] = {PLANE: _planar_force, SPACE: spatial_joint_force}
"""Force and torque of a joint by its number, q and multipliers, and their derivatives by q, multipliers and design."""
