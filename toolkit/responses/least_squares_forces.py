"""Multipliers of redundant constraints by least squares, and forces and moments of joints on both bodies.

Multipliers of redundant constraints: of all that give the same forces on the bodies those of least squares.

The run has multipliers lam that are zero for rows that repeat others (see `redundant_joints`), whose null vectors are N, J^T N = 0. With
w = G lam the forces and torques of all joints, forces times a length, that of the least sum w . w is

    mu = lam - N (N^T G^T G N)^-1 N^T G^T G lam

Derivatives: from J^T mu = J^T lam and N^T G^T G mu = 0, with dmu = p + N z, p zero for repeating rows, v = G^T w and
a = J_K^T (J_K J_K^T)^-1 v_K,

    J^T p = dJ^T (lam - mu) + J^T dlam,   N^T G^T G N z = N^T dJ a - (dG N)^T w - (G N)^T (dG mu + G p)

With f = g_z^T lam of a joint, F = - f_r and M = - f_theta at either marker, in space M = sum_i f_i x e_i of its axes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.components.joints.kernels.planar_joint import evaluate_planar_joint
from toolkit.components.joints.kernels.spatial_joint import evaluate_spatial_joint
from toolkit.scene.space import PLANE, SPACE
from toolkit.system.equations import allocate_work
from toolkit.system.redundant_joints import joint_terms
from toolkit.system.redundant_rows import null_vectors
from toolkit.system.solution import MarkerStates, Solution, marker_states
from toolkit.system.system import System

Wrenches = Callable[[np.ndarray], tuple[np.ndarray, ...]]
"""G lam and its derivatives by q, by lam and by the design, for multipliers."""


class Split(NamedTuple):
    """Least-squares multipliers, and the matrices that they are found from."""

    value: np.ndarray  # mu (n_lam,)
    jacobian: np.ndarray  # J (n_lam, n_q)
    kept: np.ndarray  # rows that repeat no others
    null: np.ndarray  # N (n_lam, n_n)


class Forces(NamedTuple):
    """Multipliers and their derivatives by q, by the run's multipliers and by the design."""

    value: np.ndarray  # (n_lam,)
    by_q: np.ndarray  # (n_lam, n_q)
    by_lam: np.ndarray  # (n_lam, n_lam)
    by_x: np.ndarray  # (n_lam, n_x)


def lengths_of_joints(system: System) -> tuple[np.ndarray, np.ndarray]:
    """Length (n_j,) that compares the forces of every joint with its torques, and its design derivatives (n_j, n_x).

    It is twice the root of the mean square distance of the undeformed places of joints from their mean, of all joints that bodies connect
    with this one other than through the ground: the distance of two hinges. So forces do not depend on what else is in the scene.
    """
    found: tuple[np.ndarray, np.ndarray] = system.scene.once(
        ("lengths of joints", *system.design.names), lambda: _lengths_of_joints(system)
    )
    return found


def _lengths_of_joints(system: System) -> tuple[np.ndarray, np.ndarray]:
    (places, places_x), groups = _places(system), _connected(system)
    lengths, lengths_x = np.ones(len(groups), places.dtype), np.zeros((len(groups), system.n_x))
    for group in np.unique(groups):
        own = groups == group
        away, away_x = (each[own].reshape(2 * np.count_nonzero(own), *each.shape[2:]) for each in (places, places_x))
        away, away_x = away - away.mean(axis=0), away_x - away_x.mean(axis=0)
        square = 4 * np.sum(away * away) / len(away)
        if np.real(square) > 0:
            lengths[own] = np.sqrt(square)
            lengths_x[own] = 4 * np.real(np.einsum("md,mdx->x", away, away_x) / (len(away) * np.sqrt(square)))
    return lengths, lengths_x


def _places(system: System) -> tuple[np.ndarray, np.ndarray]:
    """Undeformed places of both ends of every joint (n_j, 2, d), and their design derivatives (n_j, 2, d, n_x)."""
    (q, dq), markers, d = system.undeformed(), system.plan.markers, system.scene.dimension
    state, count = marker_states(system, q[: system.n_q]), len(markers.start) - 1
    places, changes = state.y[:, :d].copy(), np.zeros((count, d, system.n_x))
    for m in range(count):
        columns = slice(*markers.start[m : m + 2])
        changes[m] = np.real(state.B[columns, :d]).T @ dq[markers.coordinate[columns]]
        for k in range(*markers.design_start[m : m + 2]):
            changes[m, :, markers.design_variable[k]] += np.real(state.y_x[k, :d])
    return places[system.plan.joints.marker], changes[system.plan.joints.marker]


def _connected(system: System) -> np.ndarray:
    """Number (n_j,) of the set that every joint belongs to: sets of joints that bodies other than the ground connect."""
    bodies = [[name for name in joint.bodies if name != "ground"] for joint in system.scene.joints.values()]
    names = {name: k for k, name in enumerate(sorted({name for pair in bodies for name in pair}))}
    ties = np.array([[names[pair[0]], names[pair[-1]]] for pair in bodies], int).reshape(-1, 2)
    graph = scipy.sparse.coo_array((np.ones(len(ties)), ties.T), (len(names), len(names)))
    found: np.ndarray = scipy.sparse.csgraph.connected_components(graph, directed=False)[1][ties[:, 0]]
    return found


def least_squares_forces(system: System, q: np.ndarray, lam: np.ndarray, wrenches: Wrenches) -> Forces:
    """Least-squares multipliers (n_lam,) with derivatives, of a run from which redundant rows were dropped."""
    G = wrenches(lam)[2]
    value, jacobian, kept, N = least_squares(system, q, lam, G)
    real = (np.real(each) for each in (jacobian, N, G, lam, value))
    return Forces(value, *_derivatives(system, np.real(q), kept, wrenches, *real))


def least_squares(system: System, q: np.ndarray, lam: np.ndarray, G: np.ndarray) -> Split:
    """Least-squares multipliers without derivatives, where forces and torques of all joints are G lam."""
    n_q = system.n_q
    jacobian = system.dense(_terms(system, q, np.zeros(n_q), 0 * lam).I_acc)[n_q:, :n_q]
    repeating = system.plan.dropped - n_q
    kept = np.setdiff1d(np.arange(len(lam)), repeating)
    N = null_vectors(jacobian, kept, repeating)
    GN = G @ N
    return Split(lam - N @ np.linalg.solve(GN.T @ GN, GN.T @ (G @ lam)), jacobian, kept, N)


def _derivatives(
    system: System,
    q: np.ndarray,
    kept: np.ndarray,
    wrenches: Wrenches,
    J: np.ndarray,
    N: np.ndarray,
    G: np.ndarray,
    lam: np.ndarray,
    mu: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    GN, w, own = G @ N, G @ mu, J[kept]

    def solved(right: np.ndarray) -> np.ndarray:
        return np.linalg.solve(own @ own.T, right)

    def change(by: np.ndarray, rest: np.ndarray) -> np.ndarray:
        p = np.zeros((len(lam), by.shape[1]))
        p[kept] = solved(own @ by)
        return p + N @ np.linalg.solve(GN.T @ GN, rest - GN.T @ (G @ p))

    a = own.T @ solved((G.T @ w)[kept])
    force, rows = _blocks(system, _terms(system, q, 0 * a, lam - mu)), _blocks(system, _terms(system, q, a, 0 * lam))
    of_mu, of_null = wrenches(mu), [wrenches(column) for column in N.T]
    found = []
    for k, place in ((0, 1), (1, 3)):  # by q, by the design
        bent = np.array([w @ np.real(each[place]) for each in of_null])
        found.append(change(force[k], N.T @ rows[2 + k] - bent - GN.T @ np.real(of_mu[place])))
    return found[0], change(J.T, np.zeros((N.shape[1], len(lam)))), found[1]


def _terms(system: System, q: np.ndarray, a: np.ndarray, lam: np.ndarray):
    """Terms of the joints alone at acc = [a; lam]."""
    dtype = np.result_type(q, a, lam, system.dtype)
    return joint_terms(system, np.concatenate([q, 0 * lam]).astype(dtype), np.concatenate([a, lam]).astype(dtype))


def _blocks(system: System, terms) -> tuple[np.ndarray, ...]:
    """Derivatives d(J^T lam)/dq, d(J^T lam)/dx, d(J a)/dq, d(J a)/dx."""
    n_q, by_q = system.n_q, np.real(system.dense(terms.I_q))
    by_x = np.real(terms.I_x)
    return by_q[:n_q, :n_q], by_x[:n_q], by_q[n_q:, :n_q], by_x[n_q:]


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
