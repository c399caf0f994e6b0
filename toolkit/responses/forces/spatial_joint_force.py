"""Force and torque of a spatial joint on its body a, with their derivatives.

With f = g_z^T lam, conjugate to the pose (r, e_1, e_2, e_3) of marker a:

    F = - f_r,     M = - sum_i e_i x f_i
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from toolkit.equations.equations import Work, allocate_work
from toolkit.foundation.compiled.calls import in_memory
from toolkit.joints.kernels.records import DESIGN
from toolkit.joints.kernels.spatial_joint import NUMBERS, change_spatial_number, evaluate_spatial_joint
from toolkit.system.marker_states import MarkerStates
from toolkit.system.system import System

_NEXT, _LAST = [1, 2, 0], [2, 0, 1]
"""Numbers of the two other components of every component, in the order of a vector product."""


Force = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Force and torque of a joint (3,) or (6,), and their derivatives by coordinates, multipliers and design."""


class SpatialJointForce:
    """Force and moment (F, M) (6,) of joint j, with derivatives (6, n_q), (6, n_lam), (6, n_x), one state at a time."""

    def __init__(self, system: System, j: int) -> None:
        self.system, self.j, self._markers = system, j, MarkerStates(system)
        self._work = allocate_work(system.plan, system.dtype)
        self._acc: np.ndarray = np.zeros(system.n, system.dtype)
        given = system.functions[0], system.plan.joints, j, self._markers.found, self._acc, self._work.joint
        self._evaluate = system.prepared(evaluate_spatial_joint, *given)

    def __call__(self, q: np.ndarray, lam: np.ndarray) -> Force:
        """Force and torque with their derivatives at coordinates (n_q,) and multipliers (n_lam,)."""
        system, j, work, joints, markers = self.system, self.j, self._work, self.system.plan.joints, self.system.plan.markers
        state = self._markers.at(q)
        self._acc[system.n_q :] = lam
        self._evaluate()
        value = _wrench(work.joint.pose[0], work.joint.force[0])
        rows, count = joints.row[j] - system.n_q, joints.n_rows[j]
        by_lam: np.ndarray = np.zeros((6, system.n - system.n_q), system.dtype)
        by_lam[:, rows : rows + count] = _wrench(work.joint.pose[0], work.joint.slope[:count, 0]).T
        by_q: np.ndarray = np.zeros((6, system.n_q), system.dtype)
        by_x = np.zeros((6, system.n_x))
        _add_number_designs(system, j, work, lam[rows : rows + count], by_x)
        for side in range(2):
            m, other = joints.marker[j, side], joints.marker[j, 1 - side]
            state.rate[other] = 0
            by_pose = _by_pose(self._evaluate, state.rate[m], side, lam[rows : rows + count], work.joint)
            own, moved = slice(*markers.start[m : m + 2]), slice(*markers.design_start[m : m + 2])
            by_q[:, markers.coordinate[own]] += by_pose @ state.B[own].T
            by_x[:, markers.design_variable[moved]] += np.real(by_pose @ state.y_x[moved].T)
        return value, by_q, by_lam, by_x


def _wrench(z: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Force and moment (F, M) (..., 6) from the generalized force f (..., 24) at the poses z (24,)."""
    return np.concatenate([-f[..., :3], _moment(z, f)], axis=-1)


def _moment(z: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Moment M (..., 3) of f (..., 24) at poses z (..., 12 or 24), of which one or the other may be several."""
    e, g = (each[..., 3:12].reshape(*each.shape[:-1], 3, 3) for each in (z, f))
    moment: np.ndarray = (e[..., _LAST] * g[..., _NEXT] - e[..., _NEXT] * g[..., _LAST]).sum(axis=-2)
    return moment


def _by_pose(evaluate: Callable[[], Any], rate: np.ndarray, side: int, lam: np.ndarray, joint: Any) -> np.ndarray:
    """Derivative of (F, M) by the pose of one marker (6, 12): with a direction as its rate, the joint's kernel gives g_zz of it.

    There are as many directions as a pose has numbers, however many coordinates and variables move it.
    """
    directions, slopes = np.eye(NUMBERS // 2, dtype=rate.dtype), []
    for y in directions:
        rate[:] = y
        evaluate()
        slopes.append(lam @ joint.slope[: len(lam), 1])
    found = _wrench(joint.pose[0], np.stack(slopes))
    if side == 0:
        found[:, 3:] += _moment(directions, joint.force[0])
    return found.T


def _add_number_designs(system: System, j: int, work: Work, lam: np.ndarray, by_x: np.ndarray) -> None:
    """Add the force's derivatives by design variables that change numbers of the joint's rows, such as a length."""
    joints, joint = system.plan.joints, in_memory(work.joint) if system.compiled else work.joint
    for d in range(joints.of[j, DESIGN], joints.of[j, DESIGN + 1]):
        system.run(change_spatial_number, joints, j, d, lam[joints.design[d, 1]], np.zeros(3), joint)
        by_x[:, joints.design[d, 0]] += np.real(_wrench(work.joint.pose[0], work.joint.force[1]))
