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

from toolkit.bodies.kernels.spatial.products import multiply_spatial_block
from toolkit.bodies.kernels.spatial.small_matrices import add_nine_rows, add_three_rows, along, product, turned_dot
from toolkit.bodies.kernels.spatial.stiffening import add_stiffened_residual
from toolkit.foundation.compiled.rows import filled_up
from toolkit.foundation.kernel import inlined, inner


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
