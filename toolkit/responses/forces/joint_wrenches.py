"""Forces and moments of joints on both of their bodies, without derivatives: about the price of one evaluation each.

With f = g_z^T lam of a joint, F = - f_r and M = - f_theta at either marker, in space M = sum_i f_i x e_i of its axes.
"""

from __future__ import annotations

import numpy as np

from toolkit.equations.equations import allocate_work
from toolkit.joints.kernels.planar_joint import evaluate_planar_joint
from toolkit.joints.kernels.spatial_joint import evaluate_spatial_joint
from toolkit.responses.forces.least_squares_forces import least_squares, lengths_of_joints
from toolkit.scene.space import PLANE, SPACE
from toolkit.system.marker_states import MarkerStates
from toolkit.system.solution import Solution

KERNELS = {PLANE: evaluate_planar_joint, SPACE: evaluate_spatial_joint}


def wrenches_of_joints(solution: Solution) -> JointWrenches:
    """Joint forces and moments of a run, stored so that every state is evaluated only once."""
    if JointWrenches not in solution.known:
        solution.known[JointWrenches] = JointWrenches(solution)
    found: JointWrenches = solution.known[JointWrenches]
    return found


class JointWrenches:
    """Forces and moments of all joints of a run, with work memory for one state at a time."""

    def __init__(self, solution: Solution) -> None:
        self.solution, self.system = solution, solution.system
        self._markers, self._work = MarkerStates(self.system), allocate_work(self.system.plan, self.system.dtype)
        self._acc: np.ndarray = np.zeros(self.system.n, self.system.dtype)
        self._kept: dict[int, np.ndarray] = {}
        system, kernel, work = self.system, KERNELS[self.system.scene.space], self._work.joint
        given = system.functions[0], system.plan.joints
        self._formulas = [
            system.prepared(kernel, *given, j, self._markers.found, self._acc, work) for j in range(len(system.scene.joints))
        ]

    def at(self, step: int) -> np.ndarray:
        """Forces and moments on both bodies of every joint at a step, about the joint's point on each, (n_j, 2, 3 or 6)."""
        if step not in self._kept:
            self._kept[step] = self._evaluated(step)
        return self._kept[step]

    def _evaluated(self, step: int) -> np.ndarray:
        system, lam = self.system, self.solution.multipliers[step]
        self._markers.at(self.solution.q[step])
        if len(system.plan.dropped):
            lam = least_squares(system, self.solution.q[step], lam, self._by_multipliers()).value
        self._acc[system.n_q :] = lam
        found = []
        for formula in self._formulas:
            formula()
            found.append(self._wrenches(self._work.joint.pose[0], self._work.joint.force[0]))
        return np.real(found)

    def _by_multipliers(self) -> np.ndarray:
        """Forces, times the size of what their joints connect, and moments on the first bodies by the multipliers, (n_w, n_lam)."""
        joints, n_q, work, found = self.system.plan.joints, self.system.n_q, self._work.joint, []
        lengths = lengths_of_joints(self.system)[0]
        for j, formula in enumerate(self._formulas):
            formula()
            rows = slice(joints.row[j] - n_q, joints.row[j] - n_q + joints.n_rows[j])
            slopes = [self._wrenches(work.pose[0], row)[0] for row in work.slope[: joints.n_rows[j], 0]]
            by: np.ndarray = np.zeros((len(slopes[0]), self.system.n - n_q), self.system.dtype)
            by[:, rows] = np.stack(slopes, axis=1)
            by[: self.system.scene.dimension] *= lengths[j]
            found.append(by)
        return np.concatenate(found)

    def _wrenches(self, z: np.ndarray, f: np.ndarray) -> np.ndarray:
        """Force and moment (F, M) at both markers (2, 3 or 6) from the generalized force f at the poses z."""
        pose, force = z.reshape(2, -1), f.reshape(2, -1)
        if pose.shape[1] == len(PLANE.wrench):
            return -force
        axes, along = pose[:, 3:].reshape(2, 3, 3), force[:, 3:].reshape(2, 3, 3)
        return -np.concatenate([force[:, :3], np.cross(axes, along).sum(axis=1)], axis=1)
