"""Spatial markers in the compiled loop: pose, Jacobian and curvature terms of every point that a joint or load grips.

A marker sits at u = z0 + Z c in the frame of its body, c the elastic coordinates it feels, with three axes e_1, e_2, e_3 that the
deformation turns by the rotation vector phi = T c. Its pose is four vectors, the position and the axes, all of one form:

    y_m = r + r0 [m = 0] + A X_m,     X_0 = u,     X_m = R(phi) e_m  (m = 1, 2, 3)
    B   = dy/dq:   r: identity [m = 0],   beta_k: A_k X_m,     c_j: A X_m,j
    y'' = B q'' + b,   b = W X_m + 2 V X_m' + A X_m'' [c'' = 0]
    B_w = d(B w)/dq at constant w = v or a,   b_q = db/dq

with the matrices A, A_k, V, W, X of the body's frame (`foundation.kinematics`). r0 is the fixed origin of a frame that only turns.
A body that does not turn has A = I and no columns beta; the placement of such a body is part of z0, Z, T and e_m.

A force F on a marker is conjugate to the pose: four vectors F_m, a force and what turns the axes. A torque M is F_m = M x y_m / 2 on the
three axes. Its derivatives at constant F are

    d(B^T F)/dq:   beta_k, beta_l: F_m . A_kl X_m      beta_k, c_j: F_m . A_k X_m,j      c_i, c_j: F_m . A X_m,ij

The partial derivatives by the design differentiate z0, Z, T and e_m. With dphi = dT c and the derivatives D of R(phi) e_m by phi, for the
axes (m = 1, 2, 3):

    dX_m = D_i dphi_i + R de_m,   dX_m,j = D_i dT_ij + (D_il dphi_l + D_i[de_m]) T_ij

and likewise for X_m' and X_m''; for the position dX_0 = dz0 + dZ c.
"""

from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.kernel import inlined, inner
from toolkit.foundation.kinematics.nodal_rotation import TurnedVector, turn, turned_vector
from toolkit.foundation.kinematics.orientation import Frames, FrameState, frame_state, second_products

POSE_NUMBERS = 12
"""Numbers of a pose: four vectors of three components."""


class SpatialMarkers(NamedTuple):
    """Arrays of the markers, which never change.

    Columns of marker m are `start[m]:start[m + 1]`: r, then beta, as far as its body has them, then c.
    """

    plane: None  # these are markers in space
    frames: Frames
    pose: tuple  # 0 ... 11; its length is known when the loop is compiled
    frame: np.ndarray  # (n_m,) number of its frame; the last for bodies that do not turn
    moves: np.ndarray  # (n_m,) 3 if its body has r, otherwise 0
    turns: np.ndarray  # (n_m,) how many beta its body has
    bends: np.ndarray  # (n_m,) 1 if any T is not zero and the axes matter
    size: np.ndarray  # (n_m,) 12, or 3 where nothing asks for the axes: they stay zero
    point: np.ndarray  # (n_m, 15) z0, e_1, e_2, e_3, r0
    start: np.ndarray  # (n_m + 1,)
    coordinate: np.ndarray  # (n_columns,) global number
    shape: np.ndarray  # (n_columns, 6) rows of Z and T; zero for the frame's columns
    design_start: np.ndarray  # (n_m + 1,) into the next three
    design_variable: np.ndarray  # (n_d,)
    design_point: np.ndarray  # (n_d, 15)
    design_shape_start: np.ndarray  # (n_d,) into the next
    design_shape: np.ndarray  # (..., 6) derivative of `shape`, block after block

    def state(self, dtype: type) -> "SpatialMarkerState":
        """Memory for the state of the markers."""
        n_m, n_c, n_d = len(self.frame), len(self.coordinate), len(self.design_variable)
        rows = (n_m,) * 4 + (n_c,) * 4 + (n_d,) * 5 + (n_m,) + (n_c,)
        whole: np.ndarray = np.zeros(
            (sum(rows), POSE_NUMBERS), dtype
        )  # in one piece, of which a processor keeps track in larger pages
        numbers: list[Any] = np.split(whole, np.cumsum(rows)[:-1])
        numbers += [
            np.zeros((n_m, 6, POSE_NUMBERS), dtype), np.zeros((4, 4), dtype), np.zeros((3, 6), dtype), np.zeros((4, POSE_NUMBERS), dtype),
            np.zeros((12, POSE_NUMBERS), dtype), np.zeros((3, 6), dtype), np.zeros((4, POSE_NUMBERS), dtype),
            np.zeros((len(self.design_shape), POSE_NUMBERS), dtype), turned_vector(dtype), frame_state(self.frames, dtype),
        ]  # fmt: skip
        return SpatialMarkerState(*numbers)


class SpatialMarkerState(NamedTuple):
    """State of the markers; every pose is y_0, y_1, y_2, y_3."""

    y: np.ndarray  # (n_m, 12)
    rate: np.ndarray  # B v
    acceleration: np.ndarray  # B a
    centripetal: np.ndarray  # b
    B: np.ndarray  # (n_columns, 12)
    B_v: np.ndarray
    B_a: np.ndarray
    b_q: np.ndarray
    y_x: np.ndarray  # (n_d, 12) derivatives by the active design variables
    rate_x: np.ndarray
    acceleration_x: np.ndarray
    centripetal_x: np.ndarray
    local_x: np.ndarray  # (n_d, 12) derivatives of X_m by the active design variables
    local: np.ndarray  # (n_m, 12) X_m
    slope: np.ndarray  # (n_columns, 12) X_m,j
    bend: np.ndarray  # (n_m, 6, 12) second derivatives of X_m by phi: 11, 22, 33, 23, 13, 12
    square: np.ndarray  # (4, 4) scratch memory
    sums: np.ndarray  # (3, 6) u, phi, and their first and second derivatives by time
    motion: np.ndarray  # (4, 12) X_m', the parts of X_m'' by c'' and by c', and scratch memory
    by: np.ndarray  # (12, 12) derivatives by phi_1, phi_2, phi_3 of X_m, of X_m' and of the two parts of X_m''
    sums_x: np.ndarray  # (3, 6) as `sums`, of one design variable
    motion_x: np.ndarray  # (4, 12) of one design variable: X_m, X_m' and the two parts of X_m''
    slope_x: np.ndarray  # (..., 12) derivatives of X_m,j, in the blocks of `design_shape`
    turned: TurnedVector  # scratch memory
    frames: FrameState


@inlined
def second_index(i, j):
    """Place of the pair (i, j) in the order 11, 22, 33, 23, 13, 12."""
    return i if i == j else 6 - i - j


@inlined
def apply(size, matrix, source, target, factor):
    """target += factor * matrix source, vector by vector of a pose of `size` numbers."""
    for m in range(0, size, 3):
        a, b, c = source[m], source[m + 1], source[m + 2]
        for i in range(3):
            target[m + i] += factor * (matrix[i, 0] * a + matrix[i, 1] * b + matrix[i, 2] * c)


@inlined
def shape_sums(markers, m, q, v, acc, sums):
    """Compute u and phi, and their derivatives by time, from z0, Z and T."""
    sums[:] = 0
    for i in range(3):
        sums[0, i] = sums[0, i] + markers.point[m, i]
    for k in range(markers.start[m] + markers.moves[m] + markers.turns[m], markers.start[m + 1]):
        at = markers.coordinate[k]
        for i in range(6):
            entry = markers.shape[k, i]
            sums[0, i] += entry * q[at]
            sums[1, i] += entry * v[at]
            sums[2, i] += entry * acc[at]


@inlined
def update_local(markers, state, m):
    """Compute X_m and its derivatives in the body's frame."""
    sums, motion = state.sums, state.motion
    for i in range(3):
        state.local[m, i], motion[0, i], motion[1, i] = sums[0, i], sums[1, i], sums[2, i]
        motion[2, i] = 0
    for k in range(3, markers.size[m] if markers.bends[m] == 0 else 3):
        state.local[m, k], motion[0, k], motion[1, k], motion[2, k] = markers.point[m, k], 0, 0, 0
    for block in range(3, markers.size[m] if markers.bends[m] == 1 else 3, 3):
        turned, e = state.turned, markers.point[m, block : block + 3]
        turn(sums[0, 3:6], sums[1, 3:6], sums[2, 3:6], e, turned)
        for c in range(3):
            k = block + c
            state.local[m, k] = turned.value[c]
            for row in range(3):
                motion[row, k] = 0
            for i in range(3):
                state.by[i, k], state.by[3 + i, k] = turned.by[i, c], turned.along_rate[i, c]
                state.by[6 + i, k], state.by[9 + i, k] = turned.along_growth[i, c], turned.curved[i, c]
                motion[0, k] += turned.by[i, c] * sums[1, 3 + i]
                motion[1, k] += turned.by[i, c] * sums[2, 3 + i]
                motion[2, k] += turned.along_rate[i, c] * sums[1, 3 + i]
                for j in range(i, 3):
                    state.bend[m, second_index(i, j), k] = turned.by_by[i, j, c]


@inlined
def update_spatial_markers(markers, state, q, v, acc, linearize):
    """Evaluate all markers, without their design derivatives; their frames are up to date. B_v, B_a and b_q only to `linearize`."""
    for m in range(len(markers.frame)):
        shape_sums(markers, m, q, v, acc, state.sums)
        update_local(markers, state, m)
        update_pose(markers, state, m, q, v, acc)
        update_frame_columns(markers, state, m, linearize)
        update_elastic_columns(markers, state, m, linearize)


@inlined
def update_pose(markers, state, m, q, v, acc):
    """Compute y, B v, B a and b of one marker."""
    f, size, frames, local, motion = markers.frame[m], markers.size[m], state.frames, state.local[m], state.motion
    for array in (state.y[m], state.rate[m], state.acceleration[m], state.centripetal[m]):
        array[:size] = 0
    for i in range(3):
        state.y[m, i] = state.y[m, i] + markers.point[m, 12 + i]
    for i in range(markers.moves[m]):
        at = markers.coordinate[markers.start[m] + i]
        state.y[m, i], state.rate[m, i], state.acceleration[m, i] = q[at], v[at], acc[at]
    apply(size, frames.A[f], local, state.y[m], 1.0)
    apply(size, frames.A[f], motion[0], state.rate[m], 1.0)
    apply(size, frames.A[f], motion[1], state.acceleration[m], 1.0)
    apply(size, frames.A[f], motion[2], state.centripetal[m], 1.0)
    if markers.turns[m] > 0:
        apply(size, frames.V[f], local, state.rate[m], 1.0)
        apply(size, frames.X[f], local, state.acceleration[m], 1.0)
        apply(size, frames.W[f], local, state.centripetal[m], 1.0)
        apply(size, frames.V[f], motion[0], state.centripetal[m], 2.0)


@inlined
def update_frame_columns(markers, state, m, linearize):
    """Compute the columns of r and beta.

    A marker that feels no elastic coordinates has no X_m', and the W_k of a quaternion are zero.
    """
    f, size, frames, local, motion = markers.frame[m], markers.size[m], state.frames, state.local[m], state.motion
    first = markers.start[m] + markers.moves[m]
    for i in range(markers.moves[m]):
        state.B[markers.start[m] + i, i] = 1
    elastic = first + markers.turns[m] < markers.start[m + 1]
    for k in range(markers.turns[m]):
        B, B_v, B_a, b_q = state.B[first + k], state.B_v[first + k], state.B_a[first + k], state.b_q[first + k]
        B[:size] = 0
        apply(size, frames.A_k[f, k], local, B, 1.0)
        if not linearize:
            continue
        B_v[:size], B_a[:size], b_q[:size] = 0, 0, 0
        apply(size, frames.V_k[f, k], local, B_v, 1.0)
        apply(size, frames.X_k[f, k], local, B_a, 1.0)
        if markers.turns[m] == 1:
            apply(size, frames.W_k[f, k], local, b_q, 1.0)
        if elastic:
            apply(size, frames.A_k[f, k], motion[0], B_v, 1.0)
            apply(size, frames.A_k[f, k], motion[1], B_a, 1.0)
            apply(size, frames.V_k[f, k], motion[0], b_q, 2.0)
            apply(size, frames.A_k[f, k], motion[2], b_q, 1.0)


@inlined
def combine(rows, weights, target):
    """target = sum_i rows_i weights_i for the axes of a pose, zero for its position."""
    for k in range(3):
        target[k] = 0
    for k in range(3, 12):
        target[k] = rows[0, k] * weights[0] + rows[1, k] * weights[1] + rows[2, k] * weights[2]


@inlined
def update_elastic_columns(markers, state, m, linearize):
    """Compute the columns of the elastic coordinates."""
    f, size, frames = markers.frame[m], markers.size[m], state.frames
    for k in range(markers.start[m] + markers.moves[m] + markers.turns[m], markers.start[m + 1]):
        slope = state.slope[k]
        slope[:size], state.B[k, :size] = 0, 0
        if markers.bends[m] == 1:
            combine(state.by, markers.shape[k, 3:6], slope)
        for i in range(3):
            slope[i] = slope[i] + markers.shape[k, i]
        apply(size, frames.A[f], slope, state.B[k], 1.0)
        if not linearize:
            continue
        state.B_v[k, :size], state.B_a[k, :size], state.b_q[k, :size] = 0, 0, 0
        if markers.turns[m] > 0:
            apply(size, frames.V[f], slope, state.B_v[k], 1.0)
            apply(size, frames.X[f], slope, state.B_a[k], 1.0)
            apply(size, frames.W[f], slope, state.b_q[k], 1.0)
        if markers.bends[m] == 1:
            add_bent_column(markers, state, m, k)


@inner
def add_bent_column(markers, state, m, k):
    """Add what the curvature of R(phi) brings to a column: derivatives of X_m' and X_m'' by its coordinate."""
    f, size, frames, T, part = markers.frame[m], markers.size[m], state.frames, markers.shape[k, 3:6], state.motion[3]
    combine(state.by[3:6], T, part)
    apply(size, frames.A[f], part, state.B_v[k], 1.0)
    if markers.turns[m] > 0:
        apply(size, frames.V[f], part, state.b_q[k], 2.0)
    combine(state.by[6:9], T, part)
    apply(size, frames.A[f], part, state.B_a[k], 1.0)
    combine(state.by[9:12], T, part)
    apply(size, frames.A[f], part, state.b_q[k], 1.0)


@inlined
def add_spatial_force(markers, state, m, force, factor, residual):
    """residual += factor * B^T F for F (12,) on marker m."""
    for k in range(markers.start[m], markers.start[m + 1]):
        total = 0 * force[0]
        for c in range(markers.size[m]):
            total += state.B[k, c] * force[c]
        residual[markers.coordinate[k]] += factor * total


@inner
def outer(size, force, vectors, out):
    """Sum out = sum_m F_m X_m^T, so that sum_m F_m . M X_m = <M, out> for any matrix M."""
    for i in range(3):
        for j in range(3):
            out[i, j] = force[i] * vectors[j]
            for m in range(3, size, 3):
                out[i, j] += force[m + i] * vectors[m + j]


@inner
def turn_back(size, matrix, force, out):
    """Vectors out_m = M^T F_m, so that sum_m F_m . M X_m = sum_m out_m . X_m for any vectors X_m."""
    for m in range(0, size, 3):
        for i in range(3):
            out[m + i] = matrix[0, i] * force[m] + matrix[1, i] * force[m + 1] + matrix[2, i] * force[m + 2]


@inner
def contract(size, matrix, force, vectors):
    """Sum sum_m F_m . M X_m over the vectors of a pose."""
    total = 0 * force[0]
    for m in range(0, size, 3):
        for i in range(3):
            total += force[m + i] * (matrix[i, 0] * vectors[m] + matrix[i, 1] * vectors[m + 1] + matrix[i, 2] * vectors[m + 2])
    return total


@inner
def add_spatial_stiffness(markers, state, m, force, factor, positions, stride, offset, values):
    """values += factor * d(B^T F)/dq at constant F.

    `positions[i * stride + k]` holds where the local entry (i, k) is stored; `offset` numbers this marker's first column.
    """
    f, frames = markers.frame[m], state.frames
    n_b, first = markers.turns[m], markers.start[m] + markers.moves[m]
    turn = offset + markers.moves[m]
    square, curved = frames.scratch, state.square
    if n_b > 0:
        outer(markers.size[m], force, state.local[m], square)
        second_products(markers.frames, frames, f, square, curved)
    for i in range(n_b):
        for k in range(n_b):
            values[positions[(turn + i) * stride + turn + k]] += factor * curved[i, k]
    for i in range(n_b):
        back = state.motion[3]
        turn_back(markers.size[m], frames.A_k[f, i], force, back)
        for column in range(first + n_b, markers.start[m + 1]):
            k, entry = offset + column - markers.start[m], 0 * force[0]
            for c in range(markers.size[m]):
                entry += back[c] * state.slope[column, c]
            values[positions[(turn + i) * stride + k]] += factor * entry
            values[positions[k * stride + turn + i]] += factor * entry
    if markers.bends[m] == 1:
        add_bent_stiffness(markers, state, m, force, factor, positions, stride, offset, values)


@inner
def add_bent_stiffness(markers, state, m, force, factor, positions, stride, offset, values):
    """Add the entries between elastic coordinates, T_i . S T_j with S_il = F_m . A D_il."""
    stiffness, back, acts = state.frames.scratch, state.motion[3], False
    turn_back(markers.size[m], state.frames.A[markers.frame[m]], force, back)
    for i in range(3):
        for j in range(i, 3):
            entry = 0 * force[0]
            for c in range(3, markers.size[m]):
                entry += back[c] * state.bend[m, second_index(i, j), c]
            stiffness[i, j], stiffness[j, i] = entry, entry
            acts = acts or entry != 0
    if not acts:  # nothing turns the axes
        return
    first, last = markers.start[m] + markers.moves[m] + markers.turns[m], markers.start[m + 1]
    for row in range(first, last):
        T, at = markers.shape[row, 3:6], (offset + row - markers.start[m]) * stride + offset + first - markers.start[m]
        x = factor * (T[0] * stiffness[0, 0] + T[1] * stiffness[1, 0] + T[2] * stiffness[2, 0])
        y = factor * (T[0] * stiffness[0, 1] + T[1] * stiffness[1, 1] + T[2] * stiffness[2, 1])
        z = factor * (T[0] * stiffness[0, 2] + T[1] * stiffness[1, 2] + T[2] * stiffness[2, 2])
        for column in range(first, last):
            T = markers.shape[column]
            values[positions[at + column - first]] += x * T[3] + y * T[4] + z * T[5]


@inner
def add_spatial_force_design(markers, state, m, d, force, factor, residual_x):
    """residual_x += factor * d(B^T F)/dx at constant F, with the derivatives of X_m and X_m,j that `update_spatial_marker_designs` left."""
    x, f, frames = markers.design_variable[d], markers.frame[m], state.frames
    first = markers.start[m] + markers.moves[m]
    for k in range(markers.turns[m]):
        residual_x[markers.coordinate[first + k], x] += factor * contract(
            markers.size[m], frames.A_k[f, k], force, state.local_x[d]
        )
    for k in range(first + markers.turns[m], markers.start[m + 1]):
        row = markers.design_shape_start[d] + k - markers.start[m]
        residual_x[markers.coordinate[k], x] += factor * contract(markers.size[m], frames.A[f], force, state.slope_x[row])


@inner
def update_spatial_marker_designs(markers, state, q, v, acc):
    """Compute the partial design derivatives of y, B v, B a and b, and of X_m and X_m,j."""
    for m in range(len(markers.frame)):
        if markers.design_start[m] == markers.design_start[m + 1]:
            continue
        sum_up(markers.shape, markers.start[m], markers, m, q, v, acc, state.sums)
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            sum_up(markers.design_shape, markers.design_shape_start[d], markers, m, q, v, acc, state.sums_x)
            local_design(markers, state, m, d)
            pose_design(markers, state, m, d)


@inner
def sum_up(shape, first_row, markers, m, q, v, acc, sums):
    """Compute Z c and T c, and their derivatives by time, for the rows of one marker."""
    sums[:] = 0
    offset = markers.moves[m] + markers.turns[m]
    for k in range(offset, markers.start[m + 1] - markers.start[m]):
        at = markers.coordinate[markers.start[m] + k]
        for i in range(6):
            entry = shape[first_row + k, i]
            sums[0, i] += entry * q[at]
            sums[1, i] += entry * v[at]
            sums[2, i] += entry * acc[at]


@inner
def local_design(markers, state, m, d):
    """Compute dX_m, dX_m', both parts of dX_m'' (rows of `motion_x`), and dX_m,j."""
    motion, change = state.motion_x, state.sums_x
    for i in range(3):
        motion[0, i], motion[1, i], motion[2, i], motion[3, i] = (
            markers.design_point[d, i] + change[0, i],
            change[1, i],
            change[2, i],
            0,
        )
    first = markers.design_shape_start[d]
    count, offset = markers.start[m + 1] - markers.start[m], markers.moves[m] + markers.turns[m]
    for k in range(offset, count):
        for c in range(12):
            state.slope_x[first + k, c] = markers.design_shape[first + k, c] if c < 3 else 0
    for block in range(3, markers.size[m], 3):
        add_axis_design(markers, state, m, d, block, first, offset, count)
    for c in range(markers.size[m]):
        state.local_x[d, c] = motion[0, c]


@inner
def add_axis_design(markers, state, m, d, block, first, offset, count):
    """Add the part of one axis to the local design derivatives."""
    motion, sums, change, turned = state.motion_x, state.sums, state.sums_x, state.turned
    if markers.bends[m] == 0 and not has_rotation(markers, d, count):
        for c in range(3):
            motion[0, block + c] = markers.design_point[d, block + c]
            for row in range(1, 4):
                motion[row, block + c] = 0
        return
    turn(sums[0, 3:6], sums[1, 3:6], sums[2, 3:6], markers.design_point[d, block : block + 3], turned)
    for c in range(3):
        k = block + c
        motion[0, k] = turned.value[c]
        motion[1, k], motion[2, k], motion[3, k] = 0 * motion[0, k], 0 * motion[0, k], 0 * motion[0, k]
        for i in range(3):
            motion[1, k] += turned.by[i, c] * sums[1, 3 + i]
            motion[2, k] += turned.by[i, c] * sums[2, 3 + i]
            motion[3, k] += turned.along_rate[i, c] * sums[1, 3 + i]
    for row in range(offset, count):
        for c in range(3):
            for i in range(3):
                state.slope_x[first + row, block + c] += turned.by[i, c] * markers.shape[markers.start[m] + row, 3 + i]
    turn(sums[0, 3:6], sums[1, 3:6], sums[2, 3:6], markers.point[m, block : block + 3], turned)
    for c in range(3):
        k = block + c
        for i in range(3):
            phi, rate, growth = change[0, 3 + i], change[1, 3 + i], change[2, 3 + i]
            motion[0, k] += turned.by[i, c] * phi
            motion[1, k] += turned.along_rate[i, c] * phi + turned.by[i, c] * rate
            motion[2, k] += turned.along_growth[i, c] * phi + turned.by[i, c] * growth
            motion[3, k] += turned.curved[i, c] * phi + 2 * turned.along_rate[i, c] * rate
    for row in range(offset, count):
        at = markers.start[m] + row
        for c in range(3):
            for i in range(3):
                bent = 0 * motion[0, 0]
                for n in range(3):
                    bent += turned.by_by[i, n, c] * change[0, 3 + n]
                state.slope_x[first + row, block + c] += turned.by[i, c] * markers.design_shape[first + row, 3 + i]
                state.slope_x[first + row, block + c] += bent * markers.shape[at, 3 + i]


@inner
def has_rotation(markers, d, count):
    """Whether the variable changes any T of the marker."""
    for row in range(markers.design_shape_start[d], markers.design_shape_start[d] + count):
        for i in range(3, 6):
            if markers.design_shape[row, i] != 0:
                return True
    return False


@inner
def pose_design(markers, state, m, d):
    """Compute dy, d(B v), d(B a) and db of one marker."""
    f, size, frames, motion = markers.frame[m], markers.size[m], state.frames, state.motion_x
    y, rate, acceleration, centripetal = state.y_x[d], state.rate_x[d], state.acceleration_x[d], state.centripetal_x[d]
    for array in (y, rate, acceleration, centripetal):
        array[:] = 0
    for i in range(3):
        y[i] = y[i] + markers.design_point[d, 12 + i]
    apply(size, frames.A[f], motion[0], y, 1.0)
    apply(size, frames.A[f], motion[1], rate, 1.0)
    apply(size, frames.A[f], motion[2], acceleration, 1.0)
    apply(size, frames.A[f], motion[3], centripetal, 1.0)
    if markers.turns[m] > 0:
        apply(size, frames.V[f], motion[0], rate, 1.0)
        apply(size, frames.X[f], motion[0], acceleration, 1.0)
        apply(size, frames.W[f], motion[0], centripetal, 1.0)
        apply(size, frames.V[f], motion[1], centripetal, 2.0)
