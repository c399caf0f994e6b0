"""Deformations to second order of straight beam elements in space that turn with their chords.

An element of length L and direction e, with displacements u_i and rotation vectors phi_i of its ends, has

    a = e . (u_2 - u_1)          its elongation
    c = e x (u_2 - u_1) / L      the turn of its chord
    r = e . (phi_1 + phi_2) / 2  the mean roll of its ends
    theta_i = phi_i - c - r e    rotations of its ends against axes that turn and roll so

The exact deformations of an element whose axes T = exp(psi) turn with it, exp(theta_i) = T^T exp(phi_i), are to second order

    a + L c^2 / 2,    theta_i + c a / L + r (e x c) / 2 - (c + r e) x theta_i / 2

but for a common roll of both ends, which no force resists. In the plane of e and one normal these are those of `planar_chain`.
"""

from __future__ import annotations

import numpy as np

from toolkit.kinematics.orientation import skew
from toolkit.validity.bodies.chains.second_order import Forms

DEFORMATIONS = 7
"""Number of deformations of an element: the elongation, and three rotations of each end."""
LEVI_CIVITA = -np.array([skew(axis) for axis in np.eye(3)])
"""Symbol of the cross product: (a x b)_c = sum_ij LEVI_CIVITA[c, i, j] a_i b_j."""


def spatial_forms(nodes: np.ndarray, connectivity: np.ndarray, stiffness: np.ndarray) -> Forms:
    """Deformations of elements in space with stiffness (n_e, 12, 12) on displacements and rotations x, y, z of both ends."""
    rows, curved = deformations(nodes, connectivity)
    e = rows[:, 0, 6:9]
    still = np.zeros((len(e), 12, DEFORMATIONS))  # a displacement of every deformation
    still[:, 6:9, 0], still[:, 3:6, 1:4], still[:, 9:, 4:] = e, np.eye(3), np.eye(3)
    law = np.swapaxes(still, 1, 2) @ stiffness @ still
    dofs = (6 * connectivity[:, :, None] + np.arange(6)).reshape(-1, 12)
    return Forms(6 * len(nodes), dofs, rows, law, curved)


def deformations(nodes: np.ndarray, connectivity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Elongation and end rotations of elements between nodes (n_nodes, 3): first order (n_e, 7, 12), and Q (n_e, 7, 12, 12)."""
    sides = nodes[connectivity[:, 1]] - nodes[connectivity[:, 0]]
    lengths = np.linalg.norm(sides, axis=1)
    e = sides / lengths[:, None]
    a, c, r, theta = _linear(e, lengths)
    rows = np.concatenate([a[:, None], theta.reshape(-1, 6, 12)], axis=1)
    return rows, np.concatenate([_stretch(c, lengths)[:, None], _rotations(e, lengths, a, c, r, theta)], axis=1)


def _linear(e: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Linear forms of a (n_e, 12), c (n_e, 3, 12), r (n_e, 12) and theta (n_e, 2, 3, 12)."""
    a, c, r, theta = (np.zeros((len(e), *shape, 12)) for shape in ((), (3,), (), (2, 3)))
    for end, sign in ((0, -1), (1, 1)):
        moves, turns = slice(6 * end, 6 * end + 3), slice(6 * end + 3, 6 * end + 6)
        a[:, moves], r[:, turns] = sign * e, e / 2
        c[:, :, moves] = sign * np.array([skew(each) for each in e]) / lengths[:, None, None]
        theta[:, end, :, turns] = np.eye(3)
    theta -= (c + e[:, :, None] * r[:, None])[:, None]
    return a, c, r, theta


def _stretch(c: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    return lengths[:, None, None] * (np.swapaxes(c, 1, 2) @ c)


def _rotations(e: np.ndarray, lengths: np.ndarray, a: np.ndarray, c: np.ndarray, r: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Second-order forms Q of the rotations of both ends, (n_e, 6, 12, 12)."""
    across = np.cross(e[:, :, None], c, axis=1)
    turn = c + e[:, :, None] * r[:, None]
    common = a[:, None, :, None] * c[:, :, None] / lengths[:, None, None, None] + r[:, None, :, None] * across[:, :, None] / 2
    crossed = np.einsum("cij,eip,enjq->encpq", LEVI_CIVITA, turn, theta, optimize=True)
    found = (common[:, None] - crossed / 2).reshape(-1, 6, 12, 12)
    return found + np.swapaxes(found, 2, 3)
