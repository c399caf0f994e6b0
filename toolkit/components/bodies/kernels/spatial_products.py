"""Products of a spatial body's invariants with its motion z^ = [1; c], z' = [0; c'], a^ = [0; c''].

Integrals of pairs of modes are mostly full matrices: then they are kept as such, in rows that a processor takes several numbers of at a
time, which is seven times faster than a list of entries. Those of bodies with many zeros (nodal coordinates) are lists.

A body that its spin stiffens: with R_ab = S_ab - delta_ab tr S / 2 of the matrices S_ab of `parts.spin`, and the frame's matrices of
`spatial_floating`, the kinetic energy -omega_a omega_b (c^T S_ab c) / 2 is tr(V (c^T R c) V^T) / 2 with V = dA/dt, and adds

    inertial   k: <A_k^T X, c^T R c>
    applied    k: 2 <A_k^T V, c^T R c'> + <A_k^T W, c^T R c>
               f: -(V^T V)_ab (R_ab c)_f

It is that of the points that come nearer to the axis as the body bends, so that energy and momenta balance.
"""

from toolkit.foundation.compiled.rows import LANES, add_to_each
from toolkit.foundation.kernel import inlined, inner


@inlined
def transposed_product(a, b, out):
    """out = a^T b for matrices of three by three."""
    for i in range(3):
        for j in range(3):
            out[i, j] = a[0, i] * b[0, j] + a[1, i] * b[1, j] + a[2, i] * b[2, j]


@inlined
def by_transpose(a, s, factor, out):
    """out += factor a s^T for matrices of three by three."""
    for i in range(3):
        for j in range(3):
            out[i, j] += factor * (a[i, 0] * s[j, 0] + a[i, 1] * s[j, 1] + a[i, 2] * s[j, 2])


@inlined
def add_matrix(a, out):
    """out += a for matrices of three by three."""
    for i in range(3):
        for j in range(3):
            out[i, j] += a[i, j]


@inlined
def product(a, b):
    """<a, b>, the sum of products of all nine entries."""
    total = 0 * a[0, 0]
    for i in range(3):
        for j in range(3):
            total += a[i, j] * b[i, j]
    return total


@inlined
def flat_product(matrix, nine):
    """<a, b>, the sum of products of all nine entries, with the second matrix as nine numbers in a row."""
    total = 0 * nine[0]
    for i in range(3):
        for j in range(3):
            total += matrix[i, j] * nine[3 * i + j]
    return total


@inlined
def turned_dot(matrix, vector, other):
    """Scalar product other . (matrix vector)."""
    total = 0 * vector[0]
    for i in range(3):
        total += other[i] * (matrix[i, 0] * vector[0] + matrix[i, 1] * vector[1] + matrix[i, 2] * vector[2])
    return total


@inlined
def add_nine_rows(matrix, factor, rows, first, target):
    """target_j += factor <matrix, rows[:, first + j]>, the nine rows in the order of the matrix's entries."""
    m = matrix
    a, b, c = factor * m[0, 0], factor * m[0, 1], factor * m[0, 2]
    d, e, f = factor * m[1, 0], factor * m[1, 1], factor * m[1, 2]
    g, h, i = factor * m[2, 0], factor * m[2, 1], factor * m[2, 2]
    row_a, row_b, row_c = rows[0, first:], rows[1, first:], rows[2, first:]
    row_d, row_e, row_f = rows[3, first:], rows[4, first:], rows[5, first:]
    row_g, row_h, row_i = rows[6, first:], rows[7, first:], rows[8, first:]
    for j in range(len(target)):
        upper = a * row_a[j] + b * row_b[j] + c * row_c[j]
        middle = d * row_d[j] + e * row_e[j] + f * row_f[j]
        target[j] += upper + (middle + (g * row_g[j] + h * row_h[j] + i * row_i[j]))


@inlined
def add_three_rows(x, y, z, rows, first, target):
    """target_j += x rows[0, first + j] + y rows[1, first + j] + z rows[2, first + j]."""
    row_x, row_y, row_z = rows[0, first:], rows[1, first:], rows[2, first:]
    for j in range(len(target)):
        target[j] += x * row_x[j] + y * row_y[j] + z * row_z[j]


@inlined
def along(matrix, column, vector):
    """Entry of matrix^T vector with the number of a column."""
    return matrix[0, column] * vector[0] + matrix[1, column] * vector[1] + matrix[2, column] * vector[2]


@inner
def multiply_stiffened(part, block, n, work):
    """R c and R c', and c^T R c and c^T R c' beside the moments of the shapes."""
    for rows in (work.stiff_q, work.stiff_v):
        for k in range(9):
            rows[k, :n] = 0
    for e in range(part.stiffened_start[block], part.stiffened_start[block + 1]):
        i, j = part.stiffened_row[e], part.stiffened_column[e]
        z, dz = work.z[0, j], work.z[1, j]
        for k in range(9):
            work.stiff_q[k, i] += part.stiffening[e, k] * z
            work.stiff_v[k, i] += part.stiffening[e, k] * dz
    for k in range(9):
        total, rate = 0 * work.z[0, 0], 0 * work.z[0, 0]
        for i in range(1, n):
            total += work.z[0, i] * work.stiff_q[k, i]
            rate += work.z[0, i] * work.stiff_v[k, i]
        work.s_q[k // 3, k % 3] += total
        work.s_v[k // 3, k % 3] += rate


@inner
def add_stiffened_residual(frames, b, work, applied):
    """Add the terms of the rows c that spin stiffening brings."""
    transposed_product(frames.V[b], frames.V[b], work.pairs[0])
    add_nine_rows(work.pairs[0], -1.0, work.stiff_q, 1, applied)


@inner
def add_stiffened_jacobian(part, state, b, work, border, parts, I_q, A_q, A_v):
    """Add the entries beta by c, c by beta and c by c; those beta by beta follow from the moments of the shapes."""
    n_r, n_b, n, pairs = part.moves[b], part.turns[b], part.n_f[b], work.pairs
    applied, by_rate, (_, by_q, by_s, by_v) = work.lines[0, :n], work.lines[1, :n], parts
    for k in range(n_b):
        A_k, row = state.A_k[b, k], border[n_r + k] + n_r + n_b
        transposed_product(A_k, state.X[b], pairs[0])
        transposed_product(A_k, state.V[b], pairs[1])
        transposed_product(A_k, state.W[b], pairs[2])
        transposed_product(state.V[b], state.V_k[b, k], pairs[3])
        transposed_product(state.V[b], A_k, pairs[4])
        add_nine_rows(pairs[0], 2 * by_q, work.stiff_q, 1, I_q[row : row + n])
        add_nine_rows(pairs[1], 2 * by_s, work.stiff_v, 1, A_q[row : row + n])
        add_nine_rows(pairs[2], 2 * by_s, work.stiff_q, 1, A_q[row : row + n])
        add_nine_rows(pairs[1], 2 * by_v, work.stiff_q, 1, A_v[row : row + n])
        work.lines[:] = 0
        add_nine_rows(pairs[3], -2 * by_s, work.stiff_q, 1, applied)
        add_nine_rows(pairs[4], -2 * by_v, work.stiff_q, 1, by_rate)
        for j in range(n):
            place = border[n_r + n_b + j] + n_r + k
            A_q[place] += applied[j]
            A_v[place] += by_rate[j]
    transposed_product(state.V[b], state.V[b], pairs[0])
    for e in range(part.stiffened_start[b], part.stiffened_start[b + 1]):
        A_q[part.stiffened_position[e]] -= by_s * flat_product(pairs[0], part.stiffening[e])


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
