"""Force and torque that a joint exerts."""

from __future__ import annotations

from typing import Literal

import numpy as np

from toolkit.bodies.poses import update_pose_designs, update_poses
from toolkit.equations import allocate_work
from toolkit.joints.joint_kernel import evaluate_joint
from toolkit.responses.instant import Instant, magnitude
from toolkit.responses.response import Partials
from toolkit.solution import Solution


class JointForce(Instant):
    """Force F = - g_y^T lam of a joint on its body a, in global axes: one component, its magnitude, or the torque.

    Attributes
    ----------
    joint
        Name of the joint.
    component
        What of the force: one component, its magnitude, or the torque.
    """

    kind = "joint-force"
    quantity = "force"

    joint: str
    component: Literal["x", "y", "magnitude", "torque"]

    @property
    def unit_quantity(self) -> str:
        """A torque has another unit than a force."""
        return "torque" if self.component == "torque" else "force"

    def at(self, solution: Solution, step: int) -> Partials:
        """Value, and derivatives by coordinates, multipliers and design."""
        force, force_q, force_lam, force_x = self.force(solution, step)
        if self.component == "magnitude":

            def change() -> np.ndarray:
                dq, dlam = solution.derivative("q")[step], solution.derivative("multipliers")[step]
                return (np.real(force_q) @ dq + np.real(force_lam) @ dlam + force_x)[:2]

            size, direction = magnitude(force[:2], change)
            weights = np.append(direction, 0)
            return Partials(size, q=weights @ force_q, multipliers=weights @ force_lam, design=weights @ force_x)
        k = ("x", "y", "torque").index(self.component)
        return Partials(force[k], q=force_q[k], multipliers=force_lam[k], design=force_x[k])

    def force(self, solution: Solution, step: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """(f_x, f_y, torque) and its derivatives (3, n_q), (3, n_lam), (3, n_x)."""
        system, plan = solution.system, solution.system.plan
        j, work, markers = list(system.scene.joints).index(self.joint), allocate_work(plan, system.dtype), plan.markers
        rest: np.ndarray = np.zeros(system.n, system.dtype)
        q = np.concatenate([solution.q[step], rest[system.n_q :]])
        acc = np.concatenate([rest[: system.n_q], solution.multipliers[step]])
        for function in (update_poses, update_pose_designs):
            system.run(function, markers.plane, markers.frames, markers, work.markers, q, rest, rest, work.scratch)
        system.run(evaluate_joint, system.functions[0], plan.joints, j, markers, work.markers, acc, work.joint)
        rows = slice(plan.joints.row[j] - system.n_q, plan.joints.row[j] - system.n_q + plan.joints.n_rows[j])
        force_lam: np.ndarray = np.zeros((3, system.n - system.n_q), system.dtype)
        force_lam[:, rows] = -work.joint.phi_z[: plan.joints.n_rows[j], :3].T
        force_q: np.ndarray = np.zeros((3, system.n_q), system.dtype)
        force_x = np.zeros((3, system.n_x))
        stiffness = -work.joint.stiffness[:3] if plan.joints.curved[j] else 0 * work.joint.stiffness[:3]
        for side in range(2):
            m = plan.joints.marker[j, side]
            by_pose = stiffness[:, 3 * side : 3 * side + 3]
            for k in range(markers.start[m], markers.start[m + 1]):
                force_q[:, markers.coordinate[k]] += by_pose @ work.markers.B[k]
            for d in range(markers.design_start[m], markers.design_start[m + 1]):
                force_x[:, markers.design_variable[d]] += np.real(by_pose @ work.markers.y_x[d])
        for d in range(plan.joints.design_start[j], plan.joints.design_start[j + 1]):
            by_parameter = stiffness[:, 6 + plan.joints.design_parameter[d]]
            force_x[:, plan.joints.design_variable[d]] += np.real(by_parameter) * plan.joints.design_value[d]
        return -work.joint.force[:3], force_q, force_lam, force_x
