"""Orientation in the plane and in space: the only place that knows how it is parametrised.

A frame's rotation matrix A depends on coordinates beta: a unit quaternion p of four, or one angle about a fixed axis n,

    A(p)     = p^T L p / 2: the usual matrix of a unit quaternion, in its homogeneous form (A = |p|^2 times a rotation)
    A(theta) = n n^T + cos(theta) (I - n n^T) + sin(theta) skew(n)

With A_k = dA/dbeta_k and so on, everything else is made of these matrices and of coordinates alone:

    A' = A_k beta_k' = V           V_k = A_kl beta_l'
    A'' = X + W                    X = A_k beta_k'',  X_k = A_kl beta_l'',   W = A_kl beta_k' beta_l',  W_k = dW/dbeta_k

A quaternion is kept at unit length by a constraint of its own, (p . p - 1) / 2 = 0, with a multiplier. Because A is homogeneous in p, the
mass matrix has an inertia along p too and stays regular; what acts along p goes into that multiplier alone.
"""

from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.kernel import inner
from toolkit.foundation.near_ties import first_smallest


def rotation(angle: complex) -> np.ndarray:
    """Rotation matrix A(angle) = [[cos, -sin], [sin, cos]]; real or complex angle in rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def unit_vector(vector: np.ndarray) -> np.ndarray:
    """The vector divided by its length, also for complex components (no modulus)."""
    return vector / np.sqrt(vector @ vector)


class Frames(NamedTuple):
    """Constant numbers of the frames that turn."""

    first: np.ndarray  # (n,) global number of the first orientation coordinate
    turns: np.ndarray  # (n,) 4 for a quaternion, 1 for an angle
    axis: np.ndarray  # (n, 3) n of an angle
    row: np.ndarray  # (n,) number of the multiplier of a quaternion's length among all unknowns, or -1
    position: np.ndarray  # (n, 12) where (row, p_k), (p_k, row) and (p_k, p_k) are stored


class FrameState(NamedTuple):
    """Matrices of the head of this file, for every frame, and last for a frame that does not turn."""

    A: np.ndarray  # (n, 3, 3)
    A_k: np.ndarray  # (n, 4, 3, 3)
    A_kk: np.ndarray  # (n, 3, 3) second derivative by an angle; that of a quaternion is constant
    V: np.ndarray  # (n, 3, 3)
    V_k: np.ndarray  # (n, 4, 3, 3)
    W: np.ndarray
    W_k: np.ndarray  # (n, 4, 3, 3), zero for quaternions
    X: np.ndarray
    X_k: np.ndarray
    scratch: np.ndarray  # (3, 3)


def frame_state(frames: Frames, dtype: type) -> FrameState:
    """Memory for the matrices of all frames."""
    one, four = (len(frames.first) + 1, 3, 3), (len(frames.first) + 1, 4, 3, 3)
    state = FrameState(*(np.zeros(shape, dtype) for shape in (one, four, one, one, four, one, four, one, four, (3, 3))))
    state.A[-1] = np.eye(3)
    return state


def partials_of_quaternion(s: np.ndarray) -> np.ndarray:
    """A_kl s_l of a quaternion for s (4,), shape (4, 3, 3); for s = p these are A_k."""
    a, b, c, d = s
    return 2 * np.array(
        [
            [[a, -d, c], [d, a, -b], [-c, b, a]],
            [[b, c, d], [c, -b, -a], [d, a, -b]],
            [[-c, b, a], [b, c, d], [-a, d, -c]],
            [[-d, -a, b], [a, -d, c], [b, c, d]],
        ]
    )


@inner
def fill_partials(out, vector, first):
    """out_k = A_kl s_l of a quaternion for s = vector[first:first + 4], as `partials_of_quaternion`."""
    a, b, c, d = 2 * vector[first], 2 * vector[first + 1], 2 * vector[first + 2], 2 * vector[first + 3]
    for k in range(3):
        out[0, k, k] = a
        for i in range(3):
            out[1 + k, i, i] = -vector[first + 1 + k] * 2
        out[1 + k, k, k] = 2 * vector[first + 1 + k]
    out[0, 0, 1], out[0, 0, 2], out[0, 1, 0], out[0, 1, 2], out[0, 2, 0], out[0, 2, 1] = -d, c, d, -b, -c, b
    out[1, 0, 1], out[1, 0, 2], out[1, 1, 0], out[1, 1, 2], out[1, 2, 0], out[1, 2, 1] = c, d, c, -a, d, a
    out[2, 0, 1], out[2, 0, 2], out[2, 1, 0], out[2, 1, 2], out[2, 2, 0], out[2, 2, 1] = b, a, b, d, -a, d
    out[3, 0, 1], out[3, 0, 2], out[3, 1, 0], out[3, 1, 2], out[3, 2, 0], out[3, 2, 1] = -a, b, a, c, b, c


@inner
def weighted_sum(out, parts, vector, first, factor):
    """out = factor * parts_k s_k for s = vector[first:first + 4]."""
    for i in range(3):
        for j in range(3):
            out[i, j] = 0
            for k in range(4):
                out[i, j] += factor * parts[k, i, j] * vector[first + k]


@inner
def update_angle(frames, state, f, q, v, acc):
    """Compute the matrices of a frame that turns about a fixed axis."""
    at, n = frames.first[f], frames.axis[f]
    c, s, rate, growth = np.cos(q[at]), np.sin(q[at]), v[at], acc[at]
    for i in range(3):
        for j in range(3):
            along = n[i] * n[j]
            across = (1 if i == j else 0) - along
            skew = 0 * along if i == j else (1 if (j - i) % 3 == 2 else -1) * n[3 - i - j]
            slope, bend = c * skew - s * across, -c * across - s * skew
            state.A[f, i, j] = along + c * across + s * skew
            state.A_k[f, 0, i, j], state.A_kk[f, i, j] = slope, bend
            state.V[f, i, j], state.V_k[f, 0, i, j] = slope * rate, bend * rate
            state.W[f, i, j], state.W_k[f, 0, i, j] = bend * rate * rate, -slope * rate * rate
            state.X[f, i, j], state.X_k[f, 0, i, j] = slope * growth, bend * growth


@inner
def update_frames(frames, state, q, v, acc):
    """Compute the matrices of all frames."""
    for f in range(len(frames.first)):
        at = frames.first[f]
        if frames.turns[f] == 1:
            update_angle(frames, state, f, q, v, acc)
        else:
            fill_partials(state.A_k[f], q, at)
            fill_partials(state.V_k[f], v, at)
            fill_partials(state.X_k[f], acc, at)
            weighted_sum(state.A[f], state.A_k[f], q, at, 0.5)
            weighted_sum(state.V[f], state.A_k[f], v, at, 1.0)
            weighted_sum(state.W[f], state.V_k[f], v, at, 1.0)
            weighted_sum(state.X[f], state.A_k[f], acc, at, 1.0)


@inner
def second_products(frames, state, f, matrix, out):
    """out_kl = <A_kl, matrix>, the sums of products of all nine entries, (4, 4); of an angle only the first."""
    if frames.turns[f] == 1:
        out[0, 0] = 0 * matrix[0, 0]
        for i in range(3):
            for j in range(3):
                out[0, 0] += state.A_kk[f, i, j] * matrix[i, j]
        return
    x, y, z = 2 * matrix[0, 0], 2 * matrix[1, 1], 2 * matrix[2, 2]
    out[0, 0], out[1, 1], out[2, 2], out[3, 3] = x + y + z, x - y - z, y - x - z, z - x - y
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        out[0, 1 + k] = out[1 + k, 0] = 2 * (matrix[j, i] - matrix[i, j])
        out[1 + i, 1 + j] = out[1 + j, 1 + i] = 2 * (matrix[i, j] + matrix[j, i])


@inner
def lengths_residual(frames, q, v, acc, levels, inertial, applied):
    """The constraint (p . p - 1) / 2 = 0 of every quaternion, and its force p lam; levels as of joints."""
    for f in range(len(frames.first)):
        row, at = frames.row[f], frames.first[f]
        if row >= 0:
            growth, rate, still, square = 0 * q[at], 0 * q[at], 0 * q[at], -1 + 0 * q[at]
            for k in range(at, at + 4):
                growth += q[k] * acc[k]
                rate += v[k] * v[k]
                still += q[k] * v[k]
                square += q[k] * q[k]
                inertial[k] += q[k] * acc[row]
            inertial[row] += levels[0] * growth
            applied[row] += levels[0] * rate + levels[1] * still + levels[2] * square / 2


@inner
def lengths_jacobian(frames, q, v, acc, levels, parts, I_acc, I_q, A_q, A_v):
    """Derivatives of `lengths_residual`, each group multiplied by its part."""
    by_a, by_q, by_s, by_v = parts
    for f in range(len(frames.first)):
        row, at = frames.row[f], frames.first[f]
        if row >= 0:
            for k in range(4):
                by_row, by_column, own = frames.position[f, k], frames.position[f, 4 + k], frames.position[f, 8 + k]
                p, rate, growth = q[at + k], v[at + k], acc[at + k]
                I_acc[by_row] += by_a * levels[0] * p
                I_acc[by_column] += by_a * p
                I_q[by_row] += by_q * levels[0] * growth
                I_q[own] += by_q * acc[row]
                A_q[by_row] += by_s * (levels[1] * rate + levels[2] * p)
                A_v[by_row] += by_v * (2 * levels[0] * rate + levels[1] * p)


def skew(vector: np.ndarray) -> np.ndarray:
    """Matrix of the cross product: skew(a) b = a x b."""
    x, y, z = vector
    return np.array([[0 * x, -z, y], [z, 0 * x, -x], [-y, x, 0 * x]])


def quaternion_of(rotation_vector: np.ndarray) -> np.ndarray:
    """Unit quaternion of a rotation vector, whose length is the angle in rad; real or complex, without a modulus."""
    half = np.asarray(rotation_vector) / 2
    square = half @ half
    if np.real(square) < 1e-8:  # the series is exact to round-off, and has a derivative at zero
        sine, cosine = 1 - square / 6 + square * square / 120, 1 - square / 2 + square * square / 24
    else:
        sine, cosine = np.sin(np.sqrt(square)) / np.sqrt(square), np.cos(np.sqrt(square))
    return np.array([cosine, *(sine * half)])


def matrix_of(quaternion: np.ndarray) -> np.ndarray:
    """Rotation matrix of a unit quaternion."""
    return np.tensordot(quaternion, partials_of_quaternion(quaternion), axes=1) / 2


def quaternion_rate(quaternion: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Rate p' = p o (0, omega) / 2 of a quaternion for an angular velocity in the body's axes."""
    a, b, c, d = quaternion
    x, y, z = omega
    return np.array([-b * x - c * y - d * z, a * x + c * z - d * y, a * y + d * x - b * z, a * z + b * y - c * x]) / 2


def angular_velocity(quaternion: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """omega in the body's axes (..., 3) for p and p' (..., 4), 2 conj(p) o p'."""
    a, b, c, d = np.moveaxis(np.asarray(quaternion), -1, 0)
    e, x, y, z = np.moveaxis(np.asarray(rate), -1, 0)
    return 2 * np.stack([a * x - b * e + d * y - c * z, a * y - c * e + b * z - d * x, a * z - d * e + c * x - b * y], axis=-1)


def axes_along(direction: Any) -> np.ndarray:
    """Right-handed axes (3, 3), columns, the third along a direction of any length; smooth in it, real or complex."""
    direction = np.asarray(direction)
    third = direction / np.sqrt(direction @ direction)
    aside = np.eye(3)[first_smallest(np.abs(np.real(third)))]
    first = aside - third * (aside @ third)
    first = first / np.sqrt(first @ first)
    (x, y, z), (a, b, c) = third.tolist(), first.tolist()
    return np.array([[a, y * c - z * b, x], [b, z * a - x * c, y], [c, x * b - y * a, z]])
