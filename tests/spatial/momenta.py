"""Energies and momenta of the bodies of a scene, from the mass matrix of the compiled loop."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.kinematics.orientation import partials_of_quaternion
from toolkit.system.system import System


def momentum(system: System, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Generalised momentum M(q) v, (n_q,): the inertial forces at the acceleration v."""
    pad = np.zeros(system.n - system.n_q)
    at, rate = np.concatenate([q, pad]), np.concatenate([v, pad])
    return system.evaluate(system.inputs(0.0, np.zeros(3)), at, np.zeros(system.n), rate).inertial[: system.n_q]


def kinetic_energy(system: System, q: np.ndarray, v: np.ndarray) -> float:
    """v^T M v / 2."""
    return float(v @ momentum(system, q, v)) / 2


def strain_energy(system: System, q: np.ndarray) -> float:
    """q^T K q / 2."""
    constant = system.plan.constant
    return float(np.sum(q[constant.row] * constant.stiffness * q[constant.column])) / 2


def momenta(system: System, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Linear momentum, and angular momentum about the origin, of one body with a moving frame, (6,): Noether's theorem.

    Both are the generalised momentum along the motions that leave the body as it is: dr = e, and dr = e x r with dp = (0, e) o p / 2.
    """
    conjugate = momentum(system, q, v)
    return np.concatenate([conjugate[:3], np.cross(q[:3], conjugate[:3]) + turning(q[3:7]) @ conjugate[3:7]])


def turning(quaternion: np.ndarray) -> np.ndarray:
    """Rows (0, e_k) o p / 2 for the three axes of space, (3, 4)."""
    a, b, c, d = quaternion
    return np.array([[-b, a, -d, c], [-c, d, a, -b], [-d, -c, b, a]]) / 2


def spin(quaternion: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Angular velocity in the body's axes from A^T A' alone, (3,)."""
    A = np.tensordot(quaternion, partials_of_quaternion(quaternion), axes=1) / 2
    change = A.T @ np.tensordot(rate, partials_of_quaternion(quaternion), axes=1)
    return np.array([change[2, 1], change[0, 2], change[1, 0]])
