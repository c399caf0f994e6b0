"""Force and torque that a joint exerts.

Force and torque of a spatial joint on its body a, with their derivatives.

With f = g_z^T lam, conjugate to the pose (r, e_1, e_2, e_3) of marker a:

    F = - f_r,     M = - sum_i e_i x f_i
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np

from toolkit.components.joints.kernels.planar_joint import change_number, evaluate_planar_joint
from toolkit.components.joints.kernels.records import CURVED, DESIGN
from toolkit.components.joints.kernels.spatial_joint import NUMBERS, change_spatial_number, evaluate_spatial_joint
from toolkit.components.markers.planar import MarkerState
from toolkit.foundation.compiled.calls import in_memory
from toolkit.foundation.errors import InputError
from toolkit.responses.least_squares_forces import least_squares_forces, lengths_of_joints
from toolkit.responses.response import Instant, Partials, magnitude
from toolkit.scene.space import PLANE, SPACE, Space
from toolkit.system.equations import ScratchMemory, allocate_work
from toolkit.system.solution import MarkerStates, Solution
from toolkit.system.system import System

if TYPE_CHECKING:
    from toolkit.components.joints.kernels.records import JointWork
    from toolkit.scene.resolution import ResolvedScene

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


def _by_pose(evaluate: Callable[[], None], rate: np.ndarray, side: int, lam: np.ndarray, joint: JointWork) -> np.ndarray:
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


def _add_number_designs(system: System, j: int, work: ScratchMemory, lam: np.ndarray, by_x: np.ndarray) -> None:
    """Add the force's derivatives by design variables that change numbers of the joint's rows, such as a length."""
    joints, joint = system.plan.joints, in_memory(work.joint) if system.compiled else work.joint
    for d in range(joints.of[j, DESIGN], joints.of[j, DESIGN + 1]):
        system.run(change_spatial_number, joints, j, d, lam[joints.design[d, 1]], np.zeros(3), joint)
        by_x[:, joints.design[d, 0]] += np.real(_wrench(work.joint.pose[0], work.joint.force[1]))


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

    def check(self, scene: ResolvedScene) -> None:
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
            assert isinstance(state, MarkerState)
            self._add_by_pose(state, force_q, force_x)
        for d in range(joints.of[j, DESIGN], joints.of[j, DESIGN + 1]):
            of_row = self._acc[joints.row[j] + joints.design[d, 1]]
            system.run(change_number, joints, j, d, of_row, np.zeros(3), joint)
            force_x[:, joints.design[d, 0]] -= np.real(joint.force[1, :3])
        return force, force_q, force_lam, force_x

    def _add_by_pose(self, state: MarkerState, force_q: np.ndarray, force_x: np.ndarray) -> None:
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
