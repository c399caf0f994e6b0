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
from toolkit.joints.kernels.spatial.joint_kernel import NUMBERS, change_spatial_number, evaluate_spatial_joint
from toolkit.system.marker_states import marker_states
from toolkit.system.system import System

_NEXT, _LAST = [1, 2, 0], [2, 0, 1]
"""Of every component the two others, in the order of a vector product."""


def spatial_joint_force(
    system: System, j: int, q: np.ndarray, lam: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(F, M) of joint number j (6,), and its derivatives (6, n_q), (6, n_lam), (6, n_x); q (n_q,), lam (n_lam,)."""
    plan, work, state = system.plan, allocate_work(system.plan, system.dtype), marker_states(system, q)
    joints, markers = plan.joints, plan.markers
    acc: np.ndarray = np.concatenate([np.zeros(system.n_q, system.dtype), lam])
    evaluate = system.prepared(evaluate_spatial_joint, system.functions[0], joints, j, state, acc, work.joint)
    evaluate()
    value = _wrench(work.joint.pose[0], work.joint.force[0])
    rows, count = joints.row[j] - system.n_q, joints.n_rows[j]
    by_lam: np.ndarray = np.zeros((6, system.n - system.n_q), system.dtype)
    by_lam[:, rows : rows + count] = np.stack([_wrench(work.joint.pose[0], row) for row in work.joint.slope[:count, 0]], axis=1)
    by_q: np.ndarray = np.zeros((6, system.n_q), system.dtype)
    by_x = np.zeros((6, system.n_x))
    _add_number_designs(system, j, work, lam[rows : rows + count], by_x)
    for side in range(2):
        m, other = joints.marker[j, side], joints.marker[j, 1 - side]
        state.rate[other] = 0
        by_pose = _by_pose(evaluate, state.rate[m], side, lam[rows : rows + count], work.joint)
        own, moved = slice(*markers.start[m : m + 2]), slice(*markers.design_start[m : m + 2])
        by_q[:, markers.coordinate[own]] += by_pose @ state.B[own].T
        by_x[:, markers.design_variable[moved]] += np.real(by_pose @ state.y_x[moved].T)
    return value, by_q, by_lam, by_x


def _wrench(z: np.ndarray, f: np.ndarray) -> np.ndarray:
    """(F, M) of f (24,) at the poses z (24,)."""
    e, g = z[3:12].reshape(3, 3), f[3:12].reshape(3, 3)
    torque = (e[:, _NEXT] * g[:, _LAST] - e[:, _LAST] * g[:, _NEXT]).sum(axis=0)
    return -np.concatenate([f[:3], torque])


def _by_pose(evaluate: Callable[[], Any], rate: np.ndarray, side: int, lam: np.ndarray, joint: Any) -> np.ndarray:
    """Derivative of (F, M) by the pose of one marker (6, 12): with a direction as its rate, the joint's kernel gives g_zz of it.

    There are as many directions as a pose has numbers, however many coordinates and variables move it.
    """
    found = []
    for y in np.eye(NUMBERS // 2, dtype=rate.dtype):
        rate[:] = y
        evaluate()
        found.append(_wrench(joint.pose[0], lam @ joint.slope[: len(lam), 1]))
        if side == 0:
            found[-1][3:] += _wrench(np.concatenate([y, 0 * y]), joint.force[0])[3:]
    return np.stack(found, axis=1)


def _add_number_designs(system: System, j: int, work: Work, lam: np.ndarray, by_x: np.ndarray) -> None:
    """What the numbers of the rows change, such as a length."""
    joints, joint = system.plan.joints, in_memory(work.joint) if system.compiled else work.joint
    for d in range(joints.of[j, DESIGN], joints.of[j, DESIGN + 1]):
        system.run(change_spatial_number, joints, j, d, lam[joints.design[d, 1]], np.zeros(3), joint)
        by_x[:, joints.design[d, 0]] += np.real(_wrench(work.joint.pose[0], work.joint.force[1]))
