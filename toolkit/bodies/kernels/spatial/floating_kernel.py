"""The spatial floating frame of reference in the compiled loop: rigid and flexible bodies whose frame turns, theory section 1.

With z^ = [1; c], z' = [0; c'], a^ = [0; c''], the invariants m, N, Q[a, b], the frame's matrices A, A_k, V, W, X
(`toolkit.kinematics.spatial`), S(x, y)_ab = x^T Q[a, b] y and <P, S> = sum_ab P_ab S_ab:

    inertial   t: m r'' + A N a^ + X N z^
               k: (A_k N z^) . r'' + <A_k^T A, S(z^, a^)> + <A_k^T X, S(z^, z^)>
               f: (A N_f)^T r'' + sum_a (Q[a, a] a^)_f + (A^T X)_ab (Q[a, b] z^)_f
    applied    t: 2 V N z' + W N z^                                                    - scale m g
    (- F_v)    k: 2 <A_k^T V, S(z^, z')> + <A_k^T W, S(z^, z^)>                        - scale (A_k N z^) . g
               f: 2 (A^T V)_ab (Q[a, b] z')_f + (A^T W)_ab (Q[a, b] z^)_f              - scale (A N_f)^T g

k counts the orientation coordinates. Every term is linear in the invariants, so the design derivative is the same formula with their
derivatives. A frame that only turns has no r. A rigid body is one without elastic coordinates.
"""

from typing import NamedTuple

import numpy as np

from toolkit.foundation.kernel import inner


class SpatialFloating(NamedTuple):
    """Invariants of all bodies with a turning frame, and of their design derivatives, one block after the other.

    Blocks 0 ... n_b - 1 are the bodies; every further block is a derivative, with the same numbering as its body. Body b has frame b.
    """

    block_body: np.ndarray  # (n_blocks,)
    block_variable: np.ndarray  # (n_blocks,) -1 for the bodies themselves
    frame: np.ndarray  # (n_b,) global number of its first coordinate
    moves: np.ndarray  # (n_b,) 3 if it has r, otherwise 0
    turns: np.ndarray  # (n_b,) number of orientation coordinates
    n_f: np.ndarray  # (n_b,)
    mass: np.ndarray  # (n_blocks,)
    moment_start: np.ndarray  # (n_blocks,) into the next
    moment: np.ndarray  # (..., 3) N^T
    entry_start: np.ndarray  # (n_blocks + 1,) into the next three
    entry_row: np.ndarray  # entries of all Q[a, b] on their common pattern, numbered in z^
    entry_column: np.ndarray
    second: np.ndarray  # (n_entries, 9) Q[a, b], b running fastest
    entry_position: np.ndarray  # (entries of bodies,) where they are stored, if row and column > 0
    border_start: np.ndarray  # (n_b,) into the next: (frame, frame + n_f) rows, then (n_f, frame)
    border: np.ndarray
    gravity: np.ndarray  # (3,)
    gravity_variable: np.ndarray  # (n_d,) variables that change it
    design_gravity: np.ndarray  # (n_d, 3)

    def work(self, dtype: type) -> "SpatialFloatingWork":
        """Scratch memory."""
        n = 1 + int(max(self.n_f, default=0))
        shapes = [(3, 3)] + [(n, 9)] * 3 + [(3, 3)] * 8 + [(9, 3, 3)] + [(4, 4)] * 2
        return SpatialFloatingWork(*(np.zeros(shape, dtype) for shape in shapes))


class SpatialFloatingWork(NamedTuple):
    """Products of one block with the current state."""

    first: np.ndarray  # (3, 3): N z^, N z', N a^
    q: np.ndarray  # (1 + n_f, 9): Q[a, b] z^, b running fastest
    v: np.ndarray  # with z'
    acc: np.ndarray  # with a^
    s_q: np.ndarray  # (3, 3): S(z^, z^)
    s_v: np.ndarray  # S(z^, z')
    s_acc: np.ndarray  # S(z^, a^)
    inertial: np.ndarray  # (3, 3): A S(z^, a^)^T + X S(z^, z^)^T
    applied: np.ndarray  # 2 V S(z^, z')^T + W S(z^, z^)^T
    turned: np.ndarray  # A^T X
    rate: np.ndarray  # A^T V
    bent: np.ndarray  # A^T W
    pairs: np.ndarray  # (9, 3, 3) scratch memory
    curved_inertial: np.ndarray  # (4, 4) products with A_kl
    curved_applied: np.ndarray


@inner
def entry_of(vector, elastic, i, leading):
    """Entry i of [leading; c] for the elastic part c of a global vector, whose first entry is number `elastic`."""
    return leading + 0 * vector[0] if i == 0 else vector[elastic + i - 1]


@inner
def transposed_product(a, b, out):
    """out = a^T b for matrices of three by three."""
    for i in range(3):
        for j in range(3):
            out[i, j] = a[0, i] * b[0, j] + a[1, i] * b[1, j] + a[2, i] * b[2, j]


@inner
def by_transpose(a, s, factor, out):
    """out += factor a s^T for matrices of three by three."""
    for i in range(3):
        for j in range(3):
            out[i, j] += factor * (a[i, 0] * s[j, 0] + a[i, 1] * s[j, 1] + a[i, 2] * s[j, 2])


@inner
def product(a, b):
    """<a, b>, the sum of products of all nine entries."""
    total = 0 * a[0, 0]
    for i in range(3):
        for j in range(3):
            total += a[i, j] * b[i, j]
    return total


@inner
def flat_product(matrix, nine):
    """The same, the second matrix as nine numbers in a row."""
    total = 0 * nine[0]
    for i in range(3):
        for j in range(3):
            total += matrix[i, j] * nine[3 * i + j]
    return total


@inner
def turned_dot(matrix, vector, other):
    """other . (matrix vector)."""
    total = 0 * vector[0]
    for i in range(3):
        total += other[i] * (matrix[i, 0] * vector[0] + matrix[i, 1] * vector[1] + matrix[i, 2] * vector[2])
    return total


@inner
def multiply_spatial_block(part, frames, block, q, v, acc, work):
    """All products of one block's invariants with z^, z' and a^."""
    body = part.block_body[block]
    n, elastic = part.n_f[body], part.frame[body] + part.moves[body] + part.turns[body]
    for i in range(1 + n):
        for k in range(9):
            work.q[i, k], work.v[i, k], work.acc[i, k] = 0, 0, 0
    for array in (work.first, work.s_q, work.s_v, work.s_acc, work.inertial, work.applied):
        array[:] = 0
    for i in range(1 + n):
        z, dz, ddz = entry_of(q, elastic, i, 1.0), entry_of(v, elastic, i, 0.0), entry_of(acc, elastic, i, 0.0)
        for k in range(3):
            moment = part.moment[part.moment_start[block] + i, k]
            work.first[0, k] += moment * z
            work.first[1, k] += moment * dz
            work.first[2, k] += moment * ddz
    for e in range(part.entry_start[block], part.entry_start[block + 1]):
        i, j = part.entry_row[e], part.entry_column[e]
        z, dz, ddz = entry_of(q, elastic, j, 1.0), entry_of(v, elastic, j, 0.0), entry_of(acc, elastic, j, 0.0)
        for k in range(9):
            entry = part.second[e, k]
            work.q[i, k] += entry * z
            work.v[i, k] += entry * dz
            work.acc[i, k] += entry * ddz
    for i in range(1 + n):
        z = entry_of(q, elastic, i, 1.0)
        for k in range(9):
            work.s_q[k // 3, k % 3] += z * work.q[i, k]
            work.s_v[k // 3, k % 3] += z * work.v[i, k]
            work.s_acc[k // 3, k % 3] += z * work.acc[i, k]
    by_transpose(frames.A[body], work.s_acc, 1.0, work.inertial)
    by_transpose(frames.X[body], work.s_q, 1.0, work.inertial)
    by_transpose(frames.V[body], work.s_v, 2.0, work.applied)
    by_transpose(frames.W[body], work.s_q, 1.0, work.applied)
    if n > 0:
        transposed_product(frames.A[body], frames.X[body], work.turned)
        transposed_product(frames.A[body], frames.V[body], work.rate)
        transposed_product(frames.A[body], frames.W[body], work.bent)


@inner
def add_spatial_block(part, frames, block, acc, gravity, scale, work, inertial, applied):
    """The residual's terms of one block, for a body or for a design derivative of its invariants."""
    b = part.block_body[block]
    frame, n_r, n_b, n = part.frame[b], part.moves[b], part.turns[b], part.n_f[b]
    m, (n0, n1, n2) = part.mass[block], work.first
    for i in range(n_r):
        inertial[frame + i] += m * acc[frame + i]
        applied[frame + i] -= scale * m * gravity[i]
        for j in range(3):
            inertial[frame + i] += frames.A[b, i, j] * n2[j] + frames.X[b, i, j] * n0[j]
            applied[frame + i] += 2 * frames.V[b, i, j] * n1[j] + frames.W[b, i, j] * n0[j]
    for k in range(n_b):
        row = frame + n_r + k
        inertial[row] += product(frames.A_k[b, k], work.inertial)
        applied[row] += product(frames.A_k[b, k], work.applied) - scale * turned_dot(frames.A_k[b, k], n0, gravity)
        if n_r > 0:
            inertial[row] += turned_dot(frames.A_k[b, k], n0, acc[frame : frame + 3])
    for i in range(1, 1 + n):
        row, moment = frame + n_r + n_b + i - 1, part.moment[part.moment_start[block] + i]
        inertial[row] += work.acc[i, 0] + work.acc[i, 4] + work.acc[i, 8] + flat_product(work.turned, work.q[i])
        applied[row] += 2 * flat_product(work.rate, work.v[i]) + flat_product(work.bent, work.q[i])
        applied[row] -= scale * turned_dot(frames.A[b], moment, gravity)
        if n_r > 0:
            inertial[row] += turned_dot(frames.A[b], moment, acc[frame : frame + 3])


@inner
def spatial_residual(part, frames, q, v, acc, scale, work, inertial, applied):
    """Residual of all bodies whose frame turns."""
    for b in range(len(part.frame)):
        multiply_spatial_block(part, frames, b, q, v, acc, work)
        add_spatial_block(part, frames, b, acc, part.gravity, scale, work, inertial, applied)


@inner
def spatial_design(part, frames, q, v, acc, scale, work, I_x, A_x):
    """Partial design derivatives of the residual: derivatives of the invariants, and of gravity."""
    for block in range(len(part.frame), len(part.block_body)):
        x = part.block_variable[block]
        multiply_spatial_block(part, frames, block, q, v, acc, work)
        add_spatial_block(part, frames, block, acc, part.gravity, scale, work, I_x[:, x], A_x[:, x])
    for b in range(len(part.frame)):
        if len(part.gravity_variable) > 0:
            multiply_spatial_block(part, frames, b, q, v, acc, work)
            add_gravity_design(part, frames, b, scale, work, A_x)


@inner
def add_gravity_design(part, frames, b, scale, work, A_x):
    """One body: the terms with g, with the derivative of g in its place."""
    frame, n_r, n_b, n = part.frame[b], part.moves[b], part.turns[b], part.n_f[b]
    for d in range(len(part.gravity_variable)):
        x, change = part.gravity_variable[d], part.design_gravity[d]
        for i in range(n_r):
            A_x[frame + i, x] -= scale * part.mass[b] * change[i]
        for k in range(n_b):
            A_x[frame + n_r + k, x] -= scale * turned_dot(frames.A_k[b, k], work.first[0], change)
        for i in range(1, 1 + n):
            moment = part.moment[part.moment_start[b] + i]
            A_x[frame + n_r + n_b + i - 1, x] -= scale * turned_dot(frames.A[b], moment, change)
