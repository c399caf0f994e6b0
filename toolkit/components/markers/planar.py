"""Markers in the compiled loop: pose, Jacobian and curvature terms of every point that a joint or load grips.

A marker sits at z0 + Z c in the frame of its body (r, theta), c the elastic coordinates it feels:

    y  = [ r + A u,  theta + t0 + T c ],                   u = z0 + Z c,   A = A(theta)
    B  = dy/dq:    r: identity,   theta: [A J u, 1],       c: [A Z, T],    J = [[0, -1], [1, 0]]
    y'' = B q'' + b,    b = [-theta'^2 A u + 2 theta' A J Z c', 0]
    B_w = d(B w)/dq for a rate w = v or a:   theta: -A u w_theta + A J Z w_c,   c: A J Z w_theta
    b_q:   theta: -theta'^2 A J u - 2 theta' A Z c',   c: -theta'^2 A Z

A body without frame coordinates (grounded, or the ground) has theta = 0 and only the columns c.

Forces F on markers give B^T F and its derivatives by coordinates and design at constant F; the partial derivatives by the design are the
same formulas with z0, t0, Z, T differentiated.
"""

from typing import NamedTuple

import numpy as np

from toolkit.foundation.kernel import inlined, inner


class Markers(NamedTuple):
    """Arrays of the markers, which never change.

    Columns of marker m are `start[m]:start[m + 1]`: first r_x, r_y, theta if it has a frame.
    """

    plane: tuple  # not None: these are markers in the plane
    frames: None  # which are those of space alone
    pose: tuple  # 0, 1, 2; its length is known when the loop is compiled
    frame: np.ndarray  # (n_m,) global number of r_x, or -1
    twin: np.ndarray  # (n_m,) first marker on the same frame
    point: np.ndarray  # (n_m, 3) z0 and t0
    start: np.ndarray  # (n_m + 1,)
    coordinate: np.ndarray  # (n_columns,) global number
    shape: np.ndarray  # (n_columns, 3) rows of Z and T; zero for the frame's columns
    design_start: np.ndarray  # (n_m + 1,) into the next three
    design_variable: np.ndarray  # (n_d,)
    design_point: np.ndarray  # (n_d, 3) derivative of z0 and t0
    design_shape_start: np.ndarray  # (n_d,) into the next
    design_shape: np.ndarray  # derivative of `shape`, block after block

    def state(self, dtype: type) -> "MarkerState":
        """Memory for the state of the markers."""
        n_m, n_c, n_d = len(self.frame), len(self.coordinate), len(self.design_variable)
        return MarkerState(*(np.zeros((n, 3), dtype) for n in (n_m,) * 5 + (n_c,) * 4 + (n_d,) * 4))


class MarkerState(NamedTuple):
    """State of the markers, with pose y = (x, y, angle) of each."""

    y: np.ndarray  # (n_m, 3)
    rate: np.ndarray  # B v
    acceleration: np.ndarray  # B a
    centripetal: np.ndarray  # b
    turn: np.ndarray  # cos and sin of theta
    B: np.ndarray  # (n_columns, 3)
    B_v: np.ndarray
    B_a: np.ndarray
    b_q: np.ndarray
    y_x: np.ndarray  # (n_d, 3) derivatives by the active design variables
    rate_x: np.ndarray
    acceleration_x: np.ndarray
    centripetal_x: np.ndarray


@inlined
def rotated(column, c, s, factor, x, y):
    """Store factor * A (x, y) in the first two entries of a column."""
    column[0] = factor * (c * x - s * y)
    column[1] = factor * (s * x + c * y)


@inlined
def turned(column, c, s, factor, x, y):
    """Store factor * A J (x, y) in the first two entries of a column."""
    column[0] = factor * (-c * y - s * x)
    column[1] = factor * (-s * y + c * x)


@inlined
def shape_sum(markers, first, last, vector, out):
    """Sums Z w_c and T w_c over the columns first:last."""
    out[:] = 0
    for k in range(first, last):
        w = vector[markers.coordinate[k]]
        for i in range(3):
            out[i] += markers.shape[k, i] * w


@inlined
def update_markers(markers, state, q, v, acc, scratch):
    """Evaluate all markers, without their design derivatives. `scratch` is (3, 3)."""
    for m in range(len(markers.frame)):
        first, last, frame = markers.start[m], markers.start[m + 1], markers.frame[m]
        if frame >= 0 and last == first + 3:
            update_rigid(markers, state, m, q, v, acc)
            continue
        for i, vector in enumerate((q, v, acc)):
            shape_sum(markers, first + 3 if frame >= 0 else first, last, vector, scratch[i])
        u, du, ddu = scratch[0], scratch[1], scratch[2]
        for i in range(3):
            u[i] += markers.point[m, i]
        if frame < 0:
            for i in range(3):
                state.y[m, i], state.rate[m, i], state.acceleration[m, i] = u[i], du[i], ddu[i]
                for k in range(first, last):
                    state.B[k, i] = markers.shape[k, i]
        else:
            update_moving(markers, state, m, q, v, acc, u, du, ddu)


@inner
def update_places(markers, state, q):
    """Compute the poses of all markers, without their derivatives."""
    for m in range(len(markers.frame)):
        first, last, frame, y = markers.start[m], markers.start[m + 1], markers.frame[m], state.y[m]
        shape_sum(markers, first + 3 if frame >= 0 else first, last, q, y)
        for i in range(3):
            y[i] += markers.point[m, i]
        if frame >= 0:
            c, s = turn_of(markers, state, m, q)
            rotated(y, c, s, 1.0, y[0], y[1])
            for i in range(3):
                y[i] += q[frame + i]


@inlined
def turn_of(markers, state, m, q):
    """Cosine and sine of the angle of a marker's frame, computed at the first marker on it."""
    if markers.twin[m] == m:
        angle = q[markers.frame[m] + 2]
        state.turn[m, 0], state.turn[m, 1] = np.cos(angle), np.sin(angle)
    return state.turn[markers.twin[m], 0], state.turn[markers.twin[m], 1]


@inlined
def known_turn(markers, state, m):
    """Cosine and sine of the angle of a marker's frame once all markers have been evaluated; 1 and 0 without a frame."""
    if markers.frame[m] < 0:
        return 1.0, 0.0
    return state.turn[markers.twin[m], 0], state.turn[markers.twin[m], 1]


@inlined
def update_rigid(markers, state, m, q, v, acc):
    """Evaluate a marker whose body has a frame and no elastic coordinates that it feels: `update_moving` with Z = 0."""
    frame, point, turn = markers.frame[m], markers.point[m], markers.start[m] + 2
    c, s = turn_of(markers, state, m, q)
    x, y, omega, alpha = c * point[0] - s * point[1], s * point[0] + c * point[1], v[frame + 2], acc[frame + 2]
    square = omega * omega
    B, B_v, B_a, b_q = state.B[turn], state.B_v[turn], state.B_a[turn], state.b_q[turn]
    state.B[turn - 2, 0], state.B[turn - 1, 1], B[2] = 1, 1, 1
    B[0], B[1] = -y, x
    B_v[0], B_v[1] = -omega * x, -omega * y
    B_a[0], B_a[1] = -alpha * x, -alpha * y
    b_q[0], b_q[1] = square * y, -square * x
    state.centripetal[m, 0], state.centripetal[m, 1] = -square * x, -square * y
    state.y[m, 0], state.y[m, 1], state.y[m, 2] = q[frame] + x, q[frame + 1] + y, q[frame + 2] + point[2]
    state.rate[m, 0], state.rate[m, 1], state.rate[m, 2] = v[frame] - omega * y, v[frame + 1] + omega * x, omega
    state.acceleration[m, 0], state.acceleration[m, 1], state.acceleration[m, 2] = (
        acc[frame] - alpha * y,
        acc[frame + 1] + alpha * x,
        alpha,
    )


@inlined
def update_moving(markers, state, m, q, v, acc, u, du, ddu):
    """Evaluate a marker whose body has a frame."""
    first, last, frame = markers.start[m], markers.start[m + 1], markers.frame[m]
    c, s = turn_of(markers, state, m, q)
    omega, alpha = v[frame + 2], acc[frame + 2]
    turn = first + 2
    for i in range(2):
        state.B[first + i, i] = 1
    turned(state.B[turn], c, s, 1.0, u[0], u[1])
    state.B[turn, 2] = 1
    for k in range(turn + 1, last):
        x, y = markers.shape[k, 0], markers.shape[k, 1]
        rotated(state.B[k], c, s, 1.0, x, y)
        state.B[k, 2] = markers.shape[k, 2]
        turned(state.B_v[k], c, s, omega, x, y)
        turned(state.B_a[k], c, s, alpha, x, y)
        rotated(state.b_q[k], c, s, -omega * omega, x, y)
    rotate_sum(state.B_v[turn], c, s, -omega, u, 1.0, du)
    rotate_sum(state.B_a[turn], c, s, -alpha, u, 1.0, ddu)
    rotate_sum(state.centripetal[m], c, s, -omega * omega, u, 2 * omega, du)
    turned(state.b_q[turn], c, s, -omega * omega, u[0], u[1])
    state.b_q[turn, 0] -= 2 * omega * (c * du[0] - s * du[1])
    state.b_q[turn, 1] -= 2 * omega * (s * du[0] + c * du[1])
    rotated(state.y[m], c, s, 1.0, u[0], u[1])
    rotate_sum(state.rate[m], c, s, 0.0, u, 0.0, du)
    for i in range(2):
        state.y[m, i] += q[frame + i]
    state.y[m, 2] = q[frame + 2] + u[2]
    velocity(state.rate[m], state.B[turn], c, s, v, frame, omega, du)
    velocity(state.acceleration[m], state.B[turn], c, s, acc, frame, alpha, ddu)


@inlined
def rotate_sum(column, c, s, factor, u, factor_turned, w):
    """Store factor * A u + factor_turned * A J w in the first two entries of a column."""
    column[0] = factor * (c * u[0] - s * u[1]) + factor_turned * (-c * w[1] - s * w[0])
    column[1] = factor * (s * u[0] + c * u[1]) + factor_turned * (-s * w[1] + c * w[0])


@inlined
def velocity(out, turn, c, s, w, frame, w_theta, w_u):
    """Velocity B w = w_r + A J u w_theta + A Z w_c of a marker, and the angle's rate."""
    out[0] = w[frame] + turn[0] * w_theta + c * w_u[0] - s * w_u[1]
    out[1] = w[frame + 1] + turn[1] * w_theta + s * w_u[0] + c * w_u[1]
    out[2] = w_theta + w_u[2]


@inlined
def add_force(markers, state, m, force, factor, residual):
    """residual += factor * B^T F for a force F = (f_x, f_y, torque) on marker m."""
    for k in range(markers.start[m], markers.start[m + 1]):
        total = state.B[k, 0] * force[0] + state.B[k, 1] * force[1] + state.B[k, 2] * force[2]
        residual[markers.coordinate[k]] += factor * total


@inlined
def add_geometric_stiffness(markers, state, m, force, factor, positions, stride, offset, values):
    """values += factor * d(B^T F)/dq at constant F.

        theta, theta: -F . A u        theta, c and c, theta: F . A J Z

    `positions[i * stride + k]` holds where the local entry (i, k) is stored; `offset` numbers this marker's first column.
    """
    if markers.frame[m] < 0:
        return
    first, last = markers.start[m], markers.start[m + 1]
    turn, local = first + 2, offset + 2
    entry = state.B[turn, 0] * force[1] - state.B[turn, 1] * force[0]
    values[positions[local * stride + local]] += factor * entry
    for k in range(turn + 1, last):
        entry = state.B[k, 0] * force[1] - state.B[k, 1] * force[0]
        i = offset + k - first
        values[positions[local * stride + i]] += factor * entry
        values[positions[i * stride + local]] += factor * entry


@inlined
def add_force_design(markers, state, m, d, force, factor, c, s, residual_x):
    """residual_x += factor * d(B^T F)/dx at constant F: theta: F . A J du, c: F . A dZ + dT F_3; (c, s) of theta."""
    x = markers.design_variable[d]
    first, last, frame = markers.start[m], markers.start[m + 1], markers.frame[m]
    across, along = c * force[0] + s * force[1], -s * force[0] + c * force[1]
    if frame >= 0:
        turned_force = state.y_x[d, 0] * force[1] - state.y_x[d, 1] * force[0]
        residual_x[frame + 2, x] += factor * turned_force
    offset = markers.design_shape_start[d]
    for k in range(first + 3 if frame >= 0 else first, last):
        row = offset + k - first
        shape = markers.design_shape
        total = shape[row, 0] * across + shape[row, 1] * along + shape[row, 2] * force[2]
        residual_x[markers.coordinate[k], x] += factor * total


@inner
def update_marker_designs(markers, state, q, v, acc, scratch):
    """Compute the partial design derivatives of y, B v, B a and b: the formulas with the derivatives of z0, t0, Z, T."""
    for m in range(len(markers.frame)):
        first, last, frame = markers.start[m], markers.start[m + 1], markers.frame[m]
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            offset = markers.design_shape_start[d]
            for i, vector in enumerate((q, v, acc)):
                for j in range(3):
                    scratch[i, j] = 0
                for k in range(first + 3 if frame >= 0 else first, last):
                    for j in range(3):
                        scratch[i, j] += markers.design_shape[offset + k - first, j] * vector[markers.coordinate[k]]
            for i in range(3):
                scratch[0, i] += markers.design_point[d, i]
            store_design(markers, state, m, d, v, acc, scratch[0], scratch[1], scratch[2])


@inlined
def store_design(markers, state, m, d, v, acc, u, du, ddu):
    """Store the derivatives of one marker by one design variable."""
    frame = markers.frame[m]
    if frame < 0:
        for i in range(3):
            state.y_x[d, i], state.rate_x[d, i], state.acceleration_x[d, i] = u[i], du[i], ddu[i]
        return
    c, s = known_turn(markers, state, m)
    omega, alpha = v[frame + 2], acc[frame + 2]
    rotated(state.y_x[d], c, s, 1.0, u[0], u[1])
    state.y_x[d, 2] = u[2]
    rotate_sum(state.rate_x[d], c, s, 0.0, u, omega, u)
    rotate_sum(state.acceleration_x[d], c, s, 0.0, u, alpha, u)
    for i in range(2):
        state.rate_x[d, i] += (c * du[0] - s * du[1]) if i == 0 else (s * du[0] + c * du[1])
        state.acceleration_x[d, i] += (c * ddu[0] - s * ddu[1]) if i == 0 else (s * ddu[0] + c * ddu[1])
    state.rate_x[d, 2], state.acceleration_x[d, 2] = du[2], ddu[2]
    rotate_sum(state.centripetal_x[d], c, s, -omega * omega, u, 2 * omega, du)
