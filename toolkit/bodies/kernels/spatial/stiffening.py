"""Spatial bodies that their spin stiffens, in the compiled loop: what `floating_kernel` and its derivatives have besides.

With R_ab = S_ab - delta_ab tr S / 2 of the matrices S_ab of `parts.spin`, and the frame's matrices of the head of that file, the
kinetic energy -omega_a omega_b (c^T S_ab c) / 2 is tr(V (c^T R c) V^T) / 2 with V = dA/dt, and adds

    inertial   k: <A_k^T X, c^T R c>
    applied    k: 2 <A_k^T V, c^T R c'> + <A_k^T W, c^T R c>
               f: -(V^T V)_ab (R_ab c)_f

It is that of the points that come nearer to the axis as the body bends, so that energy and momenta balance.
"""

from toolkit.bodies.kernels.spatial.small_matrices import add_nine_rows, flat_product, transposed_product
from toolkit.foundation.kernel import inner


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
