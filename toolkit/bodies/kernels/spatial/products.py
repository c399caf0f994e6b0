"""Products of a spatial body's invariants with its motion z^ = [1; c], z' = [0; c'], a^ = [0; c''].

Integrals of pairs of modes are mostly full matrices: then they are kept as such, in rows that a processor takes several numbers of at a
time, which is seven times faster than a list of entries. Those of bodies with many zeros (nodal coordinates) are lists.
"""

from toolkit.bodies.kernels.spatial.small_matrices import by_transpose, transposed_product
from toolkit.bodies.kernels.spatial.stiffening import multiply_stiffened
from toolkit.foundation.compiled.rows import LANES, add_to_each
from toolkit.foundation.kernel import inlined


@inlined
def multiply_spatial_block(part, frames, block, q, v, acc, work):
    """Compute all products of one block's invariants with z^, z' and a^."""
    body = part.block_body[block]
    n, elastic = 1 + part.n_f[body], part.frame[body] + part.moves[body] + part.turns[body]
    for array in (work.s_q, work.s_v, work.s_acc, work.inertial, work.applied):
        array[:] = 0
    z, dz, ddz = work.z[0], work.z[1], work.z[2]
    z[0], dz[0], ddz[0] = 1, 0, 0
    for i in range(1, n):
        z[i], dz[i], ddz[i] = q[elastic + i - 1], v[elastic + i - 1], acc[elastic + i - 1]
    first_moments(part, block, n, work)
    for rows in (work.q, work.v, work.acc):
        for k in range(9):
            rows[k, : row_length(n)] = 0
    if part.full[body] == 1:
        multiply_matrices(part.matrix, part.matrix_start[block], n, work)
    else:
        multiply_entries(part, block, work)
    for k in range(9):
        row, d_row, dd_row, total, rate, growth = work.q[k], work.v[k], work.acc[k], 0 * z[0], 0 * z[0], 0 * z[0]
        for i in range(n):
            total += z[i] * row[i]
            rate += z[i] * d_row[i]
            growth += z[i] * dd_row[i]
        work.s_q[k // 3, k % 3], work.s_v[k // 3, k % 3], work.s_acc[k // 3, k % 3] = total, rate, growth
    if part.stiffened_start[block + 1] > part.stiffened_start[block]:
        multiply_stiffened(part, block, n, work)
    by_transpose(frames.A[body], work.s_acc, 1.0, work.inertial)
    by_transpose(frames.X[body], work.s_q, 1.0, work.inertial)
    by_transpose(frames.V[body], work.s_v, 2.0, work.applied)
    by_transpose(frames.W[body], work.s_q, 1.0, work.applied)
    if n > 1:
        transposed_product(frames.A[body], frames.X[body], work.turned)
        transposed_product(frames.A[body], frames.V[body], work.rate)
        transposed_product(frames.A[body], frames.W[body], work.bent)


@inlined
def first_moments(part, block, n, work):
    """N z^, N z' and N a^."""
    start = part.moment_start[block]
    for k in range(3):
        moment, total, rate, growth = part.moment[k, start : start + n], 0 * work.z[0, 0], 0 * work.z[0, 0], 0 * work.z[0, 0]
        for i in range(n):
            total += moment[i] * work.z[0, i]
            rate += moment[i] * work.z[1, i]
            growth += moment[i] * work.z[2, i]
        work.first[0, k], work.first[1, k], work.first[2, k] = total, rate, growth


@inlined
def row_length(n):
    """Length of a row of a matrix of n columns, filled up to a multiple of LANES."""
    return -(-n // LANES) * LANES


@inlined
def multiply_matrices(matrix, first, n, work):
    """Q[a, b] z^ and so on from whole matrices: column i of Q[b, a] is row i of Q[a, b]."""
    w = row_length(n)
    for k in range(9):
        to = 3 * (k % 3) + k // 3
        add_to_each((work.q[to, :w], work.v[to, :w], work.acc[to, :w]), work.z, n, matrix, first + k * w, 9 * w)


@inlined
def multiply_entries(part, block, work):
    """Q[a, b] z^ and so on from a list of entries, which is ordered by rows."""
    e, last, sums = part.entry_start[block], part.entry_start[block + 1], work.sums
    while e < last:
        i = part.entry_row[e]
        sums[:] = 0
        while e < last and part.entry_row[e] == i:
            j = part.entry_column[e]
            z, dz, ddz = work.z[0, j], work.z[1, j], work.z[2, j]
            for k in range(9):
                entry = part.second[e, k]
                sums[0, k] += entry * z
                sums[1, k] += entry * dz
                sums[2, k] += entry * ddz
            e += 1
        for k in range(9):
            work.q[k, i], work.v[k, i], work.acc[k, i] = sums[0, k], sums[1, k], sums[2, k]
