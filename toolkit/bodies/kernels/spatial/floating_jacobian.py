"""Spatial bodies in the compiled loop: derivatives of the residual of `floating_kernel` by q, v and a.

They follow from the head of that file with dA/dbeta_k = A_k, dV/dbeta_k = V_k, dW/dbeta_k = W_k, dX/dbeta_k = X_k, dV/dbeta_k' = A_k,
dW/dbeta_k' = 2 V_k and dX/dbeta_k'' = A_k.
"""

from toolkit.bodies.kernels.spatial.floating_kernel import (
    by_transpose,
    flat_product,
    multiply_spatial_block,
    product,
    transposed_product,
    turned_dot,
)
from toolkit.foundation.kernel import inner
from toolkit.kinematics.spatial import second_products


@inner
def add_moving_rows(part, frames, b, work, at, width, I_acc, I_q, A_q, A_v):
    """Entries of the rows r by r, beta and c, and of the mass matrix below."""
    n_b, n, (n0, n1, n2) = part.turns[b], part.n_f[b], work.first
    tail = (3 + n_b) * width
    for i in range(3):
        I_acc[at[i * width + i]] += part.mass[b]
        for k in range(n_b):
            place, A_k, V_k = at[i * width + 3 + k], frames.A_k[b, k, i], frames.V_k[b, k, i]
            mass, by_acc, by_q, by_v = 0 * n0[0], 0 * n0[0], 0 * n0[0], 0 * n0[0]
            for j in range(3):
                mass += A_k[j] * n0[j]
                by_acc += A_k[j] * n2[j] + frames.X_k[b, k, i, j] * n0[j]
                by_q += 2 * V_k[j] * n1[j] + frames.W_k[b, k, i, j] * n0[j]
                by_v += 2 * A_k[j] * n1[j] + 2 * V_k[j] * n0[j]
            I_acc[place] += mass
            I_acc[at[(3 + k) * width + i]] += mass
            I_q[place] += by_acc
            A_q[place] += by_q
            A_v[place] += by_v
        for j in range(n):
            place, moment = at[i * width + 3 + n_b + j], part.moment[part.moment_start[b] + 1 + j]
            mass, by_acc, by_q, by_v = 0 * n0[0], 0 * n0[0], 0 * n0[0], 0 * n0[0]
            for k in range(3):
                mass += frames.A[b, i, k] * moment[k]
                by_acc += frames.X[b, i, k] * moment[k]
                by_q += frames.W[b, i, k] * moment[k]
                by_v += 2 * frames.V[b, i, k] * moment[k]
            I_acc[place] += mass
            I_acc[at[tail + j * (3 + n_b) + i]] += mass
            I_q[place] += by_acc
            A_q[place] += by_q
            A_v[place] += by_v


@inner
def add_turning_block(part, frames, state, b, acc, gravity, scale, work, at, width, I_acc, I_q, A_q, A_v):
    """Entries beta by beta; by column l with the products A_l S^T, X_l S^T, V_l S^T and W_l S^T.

    The sums in `work` that A_k is multiplied with get the terms of r'' and g too, for the products with A_kl.
    """
    n_r, n0, frame = part.moves[b], work.first[0], part.frame[b]
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
        by_transpose(A_l, work.s_acc, 1.0, inertial)
        by_transpose(state.X_k[b, column], work.s_q, 1.0, inertial)
        by_transpose(V_l, work.s_v, 2.0, applied)
        by_transpose(state.W_k[b, column], work.s_q, 1.0, applied)
        by_transpose(A_l, work.s_v, 2.0, by_rate)
        by_transpose(V_l, work.s_q, 2.0, by_rate)
        for row in range(part.turns[b]):
            place, A_k = at[(n_r + row) * width + n_r + column], state.A_k[b, row]
            I_acc[place] += product(A_k, mass)
            I_q[place] += product(A_k, inertial) + work.curved_inertial[row, column]
            A_q[place] += product(A_k, applied) + work.curved_applied[row, column]
            A_v[place] += product(A_k, by_rate)


@inner
def add_bent_rows(part, state, b, acc, gravity, scale, work, at, width, I_acc, I_q, A_q, A_v):
    """Entries beta by c and c by beta."""
    n_r, n_b, frame = part.moves[b], part.turns[b], part.frame[b]
    tail = (n_r + n_b) * width
    for k in range(n_b):
        A_k, V_k = state.A_k[b, k], state.V_k[b, k]
        mass, X_row, V_row, W_row, X_column, V_column, W_column, V_turned = (
            work.pairs[0], work.pairs[1], work.pairs[2], work.pairs[3], work.pairs[4], work.pairs[5], work.pairs[6], work.pairs[7]
        )  # fmt: skip
        transposed_product(A_k, state.A[b], mass)
        transposed_product(A_k, state.X[b], X_row)
        transposed_product(A_k, state.V[b], V_row)
        transposed_product(A_k, state.W[b], W_row)
        transposed_product(state.A[b], state.X_k[b, k], X_column)
        transposed_product(state.A[b], V_k, V_column)
        transposed_product(state.A[b], state.W_k[b, k], W_column)
        transposed_product(state.A[b], A_k, V_turned)
        for i in range(3):
            for j in range(3):
                X_column[i, j] += X_row[i, j]
                W_column[i, j] += W_row[i, j]
                work.pairs[8][i, j] = V_column[i, j] + V_row[i, j]
        for i in range(1, 1 + part.n_f[b]):
            row, column = at[(n_r + k) * width + n_r + n_b + i - 1], at[tail + (i - 1) * (n_r + n_b) + n_r + k]
            moment, z, dz, ddz = part.moment[part.moment_start[b] + i], work.q[i], work.v[i], work.acc[i]
            inertia = both(mass, z)
            fall = scale * turned_dot(A_k, moment, gravity)
            I_acc[row] += inertia
            I_acc[column] += inertia
            I_q[row] += flat_product(mass, ddz) + flat_product(X_row, z) + both(X_row, z)
            I_q[column] += flat_product(X_column, z)
            A_q[row] += 2 * flat_product(V_row, dz) + flat_product(W_row, z) + both(W_row, z) - fall
            A_q[column] += 2 * flat_product(work.pairs[8], dz) + flat_product(W_column, z) - fall
            A_v[row] += 2 * both(V_row, z)
            A_v[column] += 2 * flat_product(V_turned, dz) + 2 * flat_product(V_column, z)
            if n_r > 0:
                pull = turned_dot(A_k, moment, acc[frame : frame + 3])
                I_q[row] += pull
                I_q[column] += pull


@inner
def both(matrix, nine):
    """<matrix, transpose of nine numbers in a row>: with Q[a, b] z^ for the nine, (z^^T Q[a, b]) contracted with the matrix."""
    total = 0 * nine[0]
    for i in range(3):
        for j in range(3):
            total += matrix[i, j] * nine[3 * j + i]
    return total


@inner
def add_bent_block(part, b, work, I_acc, I_q, A_q, A_v):
    """Entries c by c."""
    for e in range(part.entry_start[b], part.entry_start[b + 1]):
        if part.entry_row[e] > 0 and part.entry_column[e] > 0:
            place, nine = part.entry_position[e], part.second[e]
            I_acc[place] += nine[0] + nine[4] + nine[8]
            I_q[place] += flat_product(work.turned, nine)
            A_q[place] += flat_product(work.bent, nine)
            A_v[place] += 2 * flat_product(work.rate, nine)


@inner
def spatial_jacobian(part, frames, state, q, v, acc, scale, work, I_acc, I_q, A_q, A_v):
    """Derivatives of the residual by q, v and a."""
    for b in range(len(part.frame)):
        multiply_spatial_block(part, state, b, q, v, acc, work)
        at = part.border[part.border_start[b] :]
        width = part.moves[b] + part.turns[b] + part.n_f[b]
        if part.moves[b] > 0:
            add_moving_rows(part, state, b, work, at, width, I_acc, I_q, A_q, A_v)
        add_turning_block(part, frames, state, b, acc, part.gravity, scale, work, at, width, I_acc, I_q, A_q, A_v)
        if part.n_f[b] > 0:
            add_bent_rows(part, state, b, acc, part.gravity, scale, work, at, width, I_acc, I_q, A_q, A_v)
        add_bent_block(part, b, work, I_acc, I_q, A_q, A_v)
