"""Products of a spatial body's invariants with its motion z^ = [1; c], z' = [0; c'], a^ = [0; c''].

Integrals of pairs of modes are mostly full matrices: then they are kept as such, in rows that a processor takes several numbers of at a
time, which is seven times faster than a list of entries. Those of bodies with many zeros (nodal coordinates) are lists.
"""

from toolkit.bodies.kernels.spatial.small_matrices import by_transpose, transposed_product
from toolkit.bodies.kernels.spatial.stiffening import multiply_stiffened
from toolkit.foundation.kernel import inlined


@inlined
def multiply_spatial_block(part, frames, block, q, v, acc, work):
    """All products of one block's invariants with z^, z' and a^."""
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
            rows[k, :n] = 0
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
def multiply_matrices(matrix, first, n, work):
    """Q[a, b] z^ and so on from whole matrices, four of their rows at a time: column i of Q[b, a] is row i of Q[a, b]."""
    for k in range(9):
        to = 3 * (k % 3) + k // 3
        sums, d_sums, dd_sums = work.q[to], work.v[to], work.acc[to]
        z, dz, ddz, at, i = work.z[0], work.z[1], work.z[2], first + k * n, 0
        while i + 4 <= n:
            a, b = matrix[at : at + n], matrix[at + 9 * n : at + 10 * n]
            c, d = matrix[at + 18 * n : at + 19 * n], matrix[at + 27 * n : at + 28 * n]
            z_a, z_b, z_c, z_d = z[i], z[i + 1], z[i + 2], z[i + 3]
            v_a, v_b, v_c, v_d = dz[i], dz[i + 1], dz[i + 2], dz[i + 3]
            w_a, w_b, w_c, w_d = ddz[i], ddz[i + 1], ddz[i + 2], ddz[i + 3]
            for j in range(n):
                sums[j] += a[j] * z_a + b[j] * z_b + c[j] * z_c + d[j] * z_d
                d_sums[j] += a[j] * v_a + b[j] * v_b + c[j] * v_c + d[j] * v_d
                dd_sums[j] += a[j] * w_a + b[j] * w_b + c[j] * w_c + d[j] * w_d
            at += 36 * n
            i += 4
        while i < n:
            a = matrix[at : at + n]
            for j in range(n):
                sums[j] += a[j] * z[i]
                d_sums[j] += a[j] * dz[i]
                dd_sums[j] += a[j] * ddz[i]
            at += 9 * n
            i += 1


@inlined
def multiply_entries(part, block, work):
    """The same from a list of entries, which is ordered by rows."""
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
