"""The spatial floating frame of reference in the compiled loop: rigid and flexible bodies whose frame turns, theory section 1.

With z^ = [1; c], z' = [0; c'], a^ = [0; c''], the invariants m, N, Q[a, b], the frame's matrices A, A_k, V, W, X
(`toolkit.foundation.kinematics.orientation`), S(x, y)_ab = x^T Q[a, b] y and <P, S> = sum_ab P_ab S_ab:

    inertial   t: m r'' + A N a^ + X N z^
               k: (A_k N z^) . r'' + <A_k^T A, S(z^, a^)> + <A_k^T X, S(z^, z^)>
               f: (A N_f)^T r'' + sum_a (Q[a, a] a^)_f + (A^T X)_ab (Q[a, b] z^)_f
    applied    t: 2 V N z' + W N z^                                                    - scale m g
    (- F_v)    k: 2 <A_k^T V, S(z^, z')> + <A_k^T W, S(z^, z^)>                        - scale (A_k N z^) . g
               f: 2 (A^T V)_ab (Q[a, b] z')_f + (A^T W)_ab (Q[a, b] z^)_f              - scale (A N_f)^T g

k counts the orientation coordinates. Every term is linear in the invariants, so the design derivative is the same formula with their
derivatives. A frame that only turns has no r. A rigid body is one without elastic coordinates.

The derivatives of the residual by q, v and a stand behind it. They follow with dA/dbeta_k = A_k, dV/dbeta_k = V_k, dW/dbeta_k = W_k,
dX/dbeta_k = X_k, dV/dbeta_k' = A_k, dW/dbeta_k' = 2 V_k and dX/dbeta_k'' = A_k.
"""

from typing import NamedTuple

import numpy as np

from toolkit.components.bodies.kernels.spatial_products import (
    add_matrix,
    add_nine_rows,
    add_stiffened_jacobian,
    add_stiffened_residual,
    add_three_rows,
    along,
    by_transpose,
    flat_product,
    multiply_spatial_block,
    product,
    row_length,
    transposed_product,
    turned_dot,
)
from toolkit.foundation.compiled.rows import add_to_each, filled_up
from toolkit.foundation.kernel import inlined, inner
from toolkit.foundation.kinematics.orientation import second_products


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
    moment: np.ndarray  # (3, ...) N
    full: np.ndarray  # (n_b,) 1 if the Q[a, b] are kept as whole matrices, 0 if as a list of entries
    matrix_start: np.ndarray  # (n_blocks,) into the next
    matrix: np.ndarray  # rows of Q[a, b]: for each row of z^ the nine rows a, b, b running fastest, filled up
    entry_start: np.ndarray  # (n_blocks + 1,) into the next three
    entry_row: np.ndarray  # entries of all Q[a, b] on their common pattern, numbered in z^, row by row
    entry_column: np.ndarray
    second: np.ndarray  # (n_entries, 9) Q[a, b], b running fastest
    entry_position: np.ndarray  # (entries of bodies,) where they are stored, if row and column > 0
    stiffened_start: np.ndarray  # (n_blocks + 1,) into the next three: none of a body that no spin stiffens, see `stiffening`
    stiffened_row: np.ndarray  # entries of R, numbered in z^
    stiffened_column: np.ndarray
    stiffening: np.ndarray  # (n_entries, 9) R[a, b], b running fastest
    stiffened_position: np.ndarray  # (entries of bodies,) where they are stored
    border_start: np.ndarray  # (n_b,) into the next
    border: (
        np.ndarray
    )  # where each row of a body begins; the frame's columns come first, behind them c in rows that have all of it
    gravity: np.ndarray  # (3,)
    gravity_variable: np.ndarray  # (n_d,) variables that change it
    design_gravity: np.ndarray  # (n_d, 3)

    def work(self, dtype: type) -> "SpatialFloatingWork":
        """Scratch memory for the products of one block."""
        n = filled_up(1 + int(max(self.n_f, default=0)))
        rows: list[tuple[int, ...]] = [(9, n)]
        small: list[tuple[int, ...]] = [(3, 3)]
        shapes = [*small, (3, n), (3, 9), *rows * 3, *small * 8, (12, 3, 3), (4, 4), (4, 4), (5, n), *rows * 2, (5,)]
        found = SpatialFloatingWork(*(np.zeros(shape, dtype) for shape in shapes))
        found.mixed[1:] = 1
        return found


class SpatialFloatingWork(NamedTuple):
    """Products of one block with the current state."""

    first: np.ndarray  # (3, 3): N z^, N z', N a^
    z: np.ndarray  # (3, 1 + n_f filled up): z^, z', a^
    sums: np.ndarray  # (3, 9) scratch memory
    q: np.ndarray  # (9, 1 + n_f filled up): Q[a, b] z^, b running fastest
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
    pairs: np.ndarray  # (12, 3, 3) scratch memory
    curved_inertial: np.ndarray  # (4, 4) products with A_kl
    curved_applied: np.ndarray
    lines: np.ndarray  # (5, 1 + n_f) scratch memory
    stiff_q: np.ndarray  # (9, 1 + n_f): R[a, b] z^, b running fastest
    stiff_v: np.ndarray  # with z'
    mixed: np.ndarray
    """(5,) 1 where I_acc, I_q, A_q and A_v are one matrix, that of a step, and what they are multiplied by there; or 0, and ones."""


@inlined
def is_mixed(frames, work):
    """Whether derivatives go to one matrix, see `SpatialFloatingWork.mixed`; never in the plane."""
    if frames is not None:
        return work.mixed[0] != 0
    return False


@inlined
def parts_of(frames, work):
    """Factors of the derivatives by a and q of the inertial, and by q and v of the applied terms."""
    if frames is not None:
        return work.mixed[1], work.mixed[2], work.mixed[3], work.mixed[4]
    return 1.0, 1.0, 1.0, 1.0


@inlined
def add_spatial_block(part, frames, block, acc, gravity, scale, work, inertial, applied):
    """Add one block's terms of the residual, for a body or for a design derivative of its invariants."""
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
    if n > 0:
        first = frame + n_r + n_b
        add_bent_residual(
            part, frames, block, b, acc, gravity, scale, work, inertial[first : first + n], applied[first : first + n]
        )
        if part.stiffened_start[block + 1] > part.stiffened_start[block]:
            add_stiffened_residual(frames, b, work, applied[first : first + n])


@inlined
def add_bent_residual(part, frames, block, b, acc, gravity, scale, work, inertial, applied):
    """Add the terms of the rows c."""
    A, start = frames.A[b], part.moment_start[block] + 1
    for i in range(len(inertial)):
        inertial[i] += work.acc[0, 1 + i] + work.acc[4, 1 + i] + work.acc[8, 1 + i]
    add_nine_rows(work.turned, 1.0, work.q, 1, inertial)
    add_nine_rows(work.rate, 2.0, work.v, 1, applied)
    add_nine_rows(work.bent, 1.0, work.q, 1, applied)
    x, y, z = along(A, 0, gravity), along(A, 1, gravity), along(A, 2, gravity)
    add_three_rows(-scale * x, -scale * y, -scale * z, part.moment, start, applied)
    if part.moves[b] > 0:
        pull = acc[part.frame[b] : part.frame[b] + 3]
        add_three_rows(along(A, 0, pull), along(A, 1, pull), along(A, 2, pull), part.moment, start, inertial)


@inlined
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
    """Add one body's terms with g, with the derivative of g in its place."""
    frame, n_r, n_b, n = part.frame[b], part.moves[b], part.turns[b], part.n_f[b]
    for d in range(len(part.gravity_variable)):
        x, change = part.gravity_variable[d], part.design_gravity[d]
        for i in range(n_r):
            A_x[frame + i, x] -= scale * part.mass[b] * change[i]
        for k in range(n_b):
            A_x[frame + n_r + k, x] -= scale * turned_dot(frames.A_k[b, k], work.first[0], change)
        for i in range(n):
            fall = turned_dot(frames.A[b], part.moment[:, part.moment_start[b] + 1 + i], change)
            A_x[frame + n_r + n_b + i, x] -= scale * fall


@inlined
def add_moving_rows(part, frames, b, work, border, parts, I_acc, I_q, A_q, A_v):
    """Add the entries of the rows r by r, beta and c, and those of the mass matrix below."""
    n_b, n, (n0, n1, n2), (by_a, by_q, by_s, by_v) = part.turns[b], part.n_f[b], work.first, parts
    for i in range(3):
        I_acc[border[i] + i] += by_a * part.mass[b]
        for k in range(n_b):
            place, A_k, V_k = border[i] + 3 + k, frames.A_k[b, k, i], frames.V_k[b, k, i]
            mass, inertial, applied, by_rate = 0 * n0[0], 0 * n0[0], 0 * n0[0], 0 * n0[0]
            for j in range(3):
                mass += A_k[j] * n0[j]
                inertial += A_k[j] * n2[j] + frames.X_k[b, k, i, j] * n0[j]
                applied += 2 * V_k[j] * n1[j] + frames.W_k[b, k, i, j] * n0[j]
                by_rate += 2 * A_k[j] * n1[j] + 2 * V_k[j] * n0[j]
            I_acc[place] += by_a * mass
            I_acc[border[3 + k] + i] += by_a * mass
            I_q[place] += by_q * inertial
            A_q[place] += by_s * applied
            A_v[place] += by_v * by_rate
        if n > 0:
            place, start = border[i] + 3 + n_b, part.moment_start[b] + 1
            A, X, W, V = frames.A[b, i], frames.X[b, i], frames.W[b, i], frames.V[b, i]
            add_three_rows(by_q * X[0], by_q * X[1], by_q * X[2], part.moment, start, I_q[place : place + n])
            add_three_rows(by_s * W[0], by_s * W[1], by_s * W[2], part.moment, start, A_q[place : place + n])
            twice = 2 * by_v
            add_three_rows(twice * V[0], twice * V[1], twice * V[2], part.moment, start, A_v[place : place + n])
            line = work.lines[0, :n]
            line[:] = 0
            add_three_rows(by_a * A[0], by_a * A[1], by_a * A[2], part.moment, start, line)
            for j in range(n):
                I_acc[place + j] += line[j]
                I_acc[border[3 + n_b + j] + i] += line[j]


@inlined
def add_turning_block(part, frames, state, b, acc, gravity, scale, work, border, parts, I_acc, I_q, A_q, A_v):
    """Entries beta by beta; by column l with the products A_l S^T, X_l S^T, V_l S^T and W_l S^T.

    The sums in `work` that A_k is multiplied with get the terms of r'' and g too, for the products with A_kl.
    """
    n_r, n0, frame, (by_a, by_q, by_s, by_v) = part.moves[b], work.first[0], part.frame[b], parts
    for i in range(3):
        for j in range(3):
            work.inertial[i, j] += (acc[frame + i] if n_r > 0 else 0 * n0[0]) * n0[j]
            work.applied[i, j] -= scale * gravity[i] * n0[j]
    second_products(frames, state, b, work.inertial, work.curved_inertial)
    second_products(frames, state, b, work.applied, work.curved_applied)
    for column in range(part.turns[b]):
        mass, inertial, applied, by_rate = work.pairs[0], work.pairs[1], work.pairs[2], work.pairs[3]
        for array in (mass, inertial, applied, by_rate):
            array[:] = 0
        A_l, V_l = state.A_k[b, column], state.V_k[b, column]
        by_transpose(A_l, work.s_q, 1.0, mass)
        by_transpose(state.X_k[b, column], work.s_q, 1.0, inertial)
        by_transpose(V_l, work.s_q, 2.0, by_rate)
        if part.turns[b] == 1:  # W_k of a quaternion is zero
            by_transpose(state.W_k[b, column], work.s_q, 1.0, applied)
        if part.n_f[b] > 0:
            by_transpose(A_l, work.s_acc, 1.0, inertial)
            by_transpose(V_l, work.s_v, 2.0, applied)
            by_transpose(A_l, work.s_v, 2.0, by_rate)
        for row in range(part.turns[b]):
            place, A_k = border[n_r + row] + n_r + column, state.A_k[b, row]
            I_acc[place] += by_a * product(A_k, mass)
            I_q[place] += by_q * (product(A_k, inertial) + work.curved_inertial[row, column])
            A_q[place] += by_s * (product(A_k, applied) + work.curved_applied[row, column])
            A_v[place] += by_v * product(A_k, by_rate)


@inlined
def fill_pairs(state, b, k, pairs):
    """Products of the frame's matrices that the entries between beta_k and c are made of; in brackets the place of each.

    A_k^T A [0], A^T A_k [1], A_k^T X + X^T A_k [2], A^T X_k + A_k^T X [3], A_k^T V [4], V^T A_k [5], A^T V_k [6], A^T V_k + A_k^T V [7],
    A_k^T W + W^T A_k [8], A^T W_k + A_k^T W [9]
    """
    A, A_k = state.A[b], state.A_k[b, k]
    transposed_product(A_k, A, pairs[0])
    transposed_product(A, A_k, pairs[1])
    transposed_product(A_k, state.X[b], pairs[2])
    transposed_product(A, state.X_k[b, k], pairs[3])
    transposed_product(A_k, state.V[b], pairs[4])
    transposed_product(state.V[b], A_k, pairs[5])
    transposed_product(A, state.V_k[b, k], pairs[6])
    transposed_product(A, state.V_k[b, k], pairs[7])
    transposed_product(A_k, state.W[b], pairs[8])
    transposed_product(A, state.W_k[b, k], pairs[9])
    add_matrix(pairs[2], pairs[3])
    add_matrix(pairs[4], pairs[7])
    add_matrix(pairs[8], pairs[9])
    transposed_product(state.X[b], A_k, pairs[10])
    transposed_product(state.W[b], A_k, pairs[11])
    add_matrix(pairs[10], pairs[2])
    add_matrix(pairs[11], pairs[8])


@inlined
def add_bent_rows(part, state, b, acc, gravity, scale, work, border, parts, I_acc, I_q, A_q, A_v):
    """Add the entries beta by c and c by beta."""
    n_r, n, start, pairs = part.moves[b], part.n_f[b], part.moment_start[b] + 1, work.pairs
    mass, inertial, applied, by_rate = work.lines[0, :n], work.lines[1, :n], work.lines[2, :n], work.lines[3, :n]
    by_a, by_q, by_s, by_v = parts
    for k in range(part.turns[b]):
        A_k, row = state.A_k[b, k], border[n_r + k] + n_r + part.turns[b]
        fill_pairs(state, b, k, pairs)
        work.lines[:] = 0
        add_nine_rows(pairs[1], 1.0, work.q, 1, mass)
        add_nine_rows(pairs[3], 1.0, work.q, 1, inertial)
        add_nine_rows(pairs[7], 2.0, work.v, 1, applied)
        add_nine_rows(pairs[9], 1.0, work.q, 1, applied)
        add_nine_rows(pairs[1], 2.0, work.v, 1, by_rate)
        add_nine_rows(pairs[6], 2.0, work.q, 1, by_rate)
        row_q, row_s = I_q[row : row + n], A_q[row : row + n]
        add_nine_rows(pairs[0], by_q, work.acc, 1, row_q)
        add_nine_rows(pairs[2], by_q, work.q, 1, row_q)
        add_nine_rows(pairs[4], 2 * by_s, work.v, 1, row_s)
        add_nine_rows(pairs[8], by_s, work.q, 1, row_s)
        add_nine_rows(pairs[5], 2 * by_v, work.q, 1, A_v[row : row + n])
        x, y, z = -scale * along(A_k, 0, gravity), -scale * along(A_k, 1, gravity), -scale * along(A_k, 2, gravity)
        add_three_rows(x, y, z, part.moment, start, applied)
        add_three_rows(by_s * x, by_s * y, by_s * z, part.moment, start, row_s)
        if n_r > 0:
            pull = acc[part.frame[b] : part.frame[b] + 3]
            x, y, z = along(A_k, 0, pull), along(A_k, 1, pull), along(A_k, 2, pull)
            add_three_rows(x, y, z, part.moment, start, inertial)
            add_three_rows(by_q * x, by_q * y, by_q * z, part.moment, start, row_q)
        for j in range(n):
            place = border[n_r + part.turns[b] + j] + n_r + k
            I_acc[row + j] += by_a * mass[j]
            I_acc[place] += by_a * mass[j]
            I_q[place] += by_q * inertial[j]
            A_q[place] += by_s * applied[j]
            A_v[place] += by_v * by_rate[j]


@inlined
def add_bent_entries(part, b, work, parts, I_acc, I_q, A_q, A_v):
    """Add the entries c by c from a list of entries."""
    by_a, by_q, by_s, by_v = parts
    for e in range(part.entry_start[b], part.entry_start[b + 1]):
        if part.entry_row[e] > 0 and part.entry_column[e] > 0:
            place, nine = part.entry_position[e], part.second[e]
            I_acc[place] += by_a * (nine[0] + nine[4] + nine[8])
            I_q[place] += by_q * flat_product(work.turned, nine)
            A_q[place] += by_s * flat_product(work.bent, nine)
            A_v[place] += 2 * by_v * flat_product(work.rate, nine)


@inlined
def add_bent_matrices(part, b, work, border, I_acc, I_q, A_q, A_v):
    """Add the entries c by c from whole matrices."""
    n, size = 1 + part.n_f[b], part.moves[b] + part.turns[b]
    w, matrix, factors = row_length(n), part.matrix, work.sums
    for k in range(9):
        i, j = k // 3, k % 3
        factors[0, k], factors[1, k], factors[2, k] = work.turned[i, j], work.bent[i, j], 2 * work.rate[i, j]
    for i in range(1, n):
        place, at = border[size + i - 1] + size, part.matrix_start[b] + 9 * w * i
        add_bent_row(n, w, matrix, at, work, I_acc[place:], I_q[place:], A_q[place:], A_v[place:])


@inlined
def add_bent_row(n, w, matrix, at, work, mass, by_acc, by_q, by_v):
    """Add one row of the entries c by c from whole matrices."""
    one, two, three = work.lines[0, :w], work.lines[1, :w], work.lines[2, :w]
    one[:] = 0
    two[:] = 0
    three[:] = 0
    add_to_each((one, two, three), work.sums, 9, matrix, at, w)
    x, y, z = matrix[at + 1 :], matrix[at + 4 * w + 1 :], matrix[at + 8 * w + 1 :]
    for j in range(n - 1):
        mass[j] += x[j] + y[j] + z[j]
    for j in range(n - 1):
        by_acc[j] += one[1 + j]
    for j in range(n - 1):
        by_q[j] += two[1 + j]
    for j in range(n - 1):
        by_v[j] += three[1 + j]


@inlined
def add_mixed_matrices(part, b, work, border, parts, matrix):
    """Add the entries c by c from whole matrices to one matrix, see `parts_of`."""
    n, size, (by_a, by_q, by_s, by_v) = 1 + part.n_f[b], part.moves[b] + part.turns[b], parts
    w, factors, line = row_length(n), work.sums, work.lines[0, : row_length(n)]
    for k in range(9):
        i, j = k // 3, k % 3
        factors[0, k] = by_q * work.turned[i, j] + by_s * work.bent[i, j] + 2 * by_v * work.rate[i, j]
        factors[0, k] += by_a if i == j else 0.0
    for i in range(1, n):
        line[:] = 0
        add_to_each((line,), factors, 9, part.matrix, part.matrix_start[b] + 9 * w * i, w)
        row = matrix[border[size + i - 1] + size :]
        for j in range(n - 1):
            row[j] += line[1 + j]


@inlined
def spatial_linearized(part, frames, state, q, v, acc, scale, work, inertial, applied, I_acc, I_q, A_q, A_v):
    """Residual of all bodies whose frame turns, and its derivatives by q, v and a."""
    parts = parts_of(frames, work)
    for b in range(len(part.frame)):
        multiply_spatial_block(part, state, b, q, v, acc, work)
        add_spatial_block(part, state, b, acc, part.gravity, scale, work, inertial, applied)
        border = part.border[part.border_start[b] :]
        if part.moves[b] > 0:
            add_moving_rows(part, state, b, work, border, parts, I_acc, I_q, A_q, A_v)
        add_turning_block(part, frames, state, b, acc, part.gravity, scale, work, border, parts, I_acc, I_q, A_q, A_v)
        if part.n_f[b] > 0:
            add_bent_rows(part, state, b, acc, part.gravity, scale, work, border, parts, I_acc, I_q, A_q, A_v)
        if part.stiffened_start[b + 1] > part.stiffened_start[b]:
            add_stiffened_jacobian(part, state, b, work, border, parts, I_q, A_q, A_v)
        if part.full[b] == 1 and work.mixed[0] != 0:
            add_mixed_matrices(part, b, work, border, parts, I_acc)
        elif part.full[b] == 1:
            add_bent_matrices(part, b, work, border, I_acc, I_q, A_q, A_v)
        else:
            add_bent_entries(part, b, work, parts, I_acc, I_q, A_q, A_v)
