"""The planar floating frame of reference in the compiled loop: flexible bodies with a moving frame, theory section 1.

With z^ = [1; c], z' = [0; c'], a^ = [0; c''], J = [[0, -1], [1, 0]] and invariants m, N, G, H:

    inertial   t: m r'' + A J N z^ theta'' + A N a^
               r: (A J N z^) . r'' + (z^ G z^) theta'' + z^ H a^
               f: (A N_f)^T r'' + (H^T z^)_f theta'' + (G a^)_f
    applied    t: -theta'^2 A N z^ + 2 theta' A J N z'          - scale m g
    (- F_v)    r: 2 theta' z^ G z'                              - scale (A J N z^) . g
               f: -theta'^2 (G z^)_f - 2 theta' (H z')_f        - scale (A N_f)^T g

Every term is linear in the invariants, so the design derivative is the same formula with their derivatives. Stiffness and damping
belong to the constant part.

The spin of a body that it stiffens has G - S in the place of G, but not in the product with a^: the kinetic energy
z' G z' / 2 + ... + theta'^2 z^ (G - S) z^ / 2 is that of the body whose points come nearer to the axis as it bends, and from it all these
terms follow, so that energy and momenta balance.

The derivatives of the residual by q, v and a stand behind it.
"""

from typing import NamedTuple

import numpy as np

from toolkit.foundation.kernel import inlined


class Floating(NamedTuple):
    """Invariants of all bodies with a moving frame, and of their design derivatives, one block after the other.

    Blocks 0 ... n_b - 1 are the bodies; every further block is a derivative, with the same numbering as its body.
    """

    block_body: np.ndarray  # (n_blocks,)
    block_variable: np.ndarray  # (n_blocks,) -1 for the bodies themselves
    frame: np.ndarray  # (n_b,) global number of r_x; theta and the elastic coordinates follow
    n_f: np.ndarray  # (n_b,)
    mass: np.ndarray  # (n_blocks,)
    moment_start: np.ndarray  # (n_blocks,) into the next
    moment: np.ndarray  # (..., 2) N^T
    entry_start: np.ndarray  # (n_blocks + 1,) into the next four
    entry_row: np.ndarray  # entries of G and H on their common pattern, numbered in z^
    entry_column: np.ndarray
    inertia: np.ndarray
    gyroscopic: np.ndarray
    entry_position: np.ndarray  # (entries of bodies,) where they are stored, if row and column > 0
    stiffened_start: np.ndarray  # (n_blocks + 1,) into the next three: none of a body that no spin stiffens
    stiffened_row: np.ndarray  # entries of S, numbered in z^
    stiffened_column: np.ndarray
    stiffening: np.ndarray
    stiffened_position: np.ndarray  # (entries of bodies,) where they are stored
    border_start: np.ndarray  # (n_b,) into the next: (3, 3 + n_f) rows, then (n_f, 3)
    border: np.ndarray
    gravity: np.ndarray  # (2,)
    gravity_variable: np.ndarray  # (n_d,) variables that change it
    design_gravity: np.ndarray  # (n_d, 2)

    def work(self, dtype: type) -> "FloatingWork":
        """Scratch memory for the products of one block."""
        return FloatingWork(np.zeros((3, 2), dtype), np.zeros((6, 1 + int(max(self.n_f, default=0))), dtype))


class FloatingWork(NamedTuple):
    """Products of one block with the current state."""

    first: np.ndarray  # (3, 2): N z^, N z', N a^, rotated by A
    products: np.ndarray  # (6, 1 + n_f): (G - S) z^, (G - S) z', G a^, H z^, H z', H a^


@inlined
def hat(vector, frame, i, leading):
    """Entry i of [leading; c], for the elastic part c of a global vector."""
    return leading + 0 * vector[frame] if i == 0 else vector[frame + 2 + i]


@inlined
def multiply_block(part, block, q, v, acc, work):
    """Compute all products of one block's invariants with z^, z' and a^."""
    body = part.block_body[block]
    frame, n = part.frame[body], part.n_f[body]
    c, s = np.cos(q[frame + 2]), np.sin(q[frame + 2])
    work.first[:] = 0
    work.products[:] = 0
    for i in range(1 + n):
        for k in range(2):
            moment = part.moment[part.moment_start[block] + i, k]
            work.first[0, k] += moment * hat(q, frame, i, 1.0)
            work.first[1, k] += moment * hat(v, frame, i, 0.0)
            work.first[2, k] += moment * hat(acc, frame, i, 0.0)
    for k in range(3):
        x, y = work.first[k, 0], work.first[k, 1]
        work.first[k, 0], work.first[k, 1] = c * x - s * y, s * x + c * y
    for e in range(part.entry_start[block], part.entry_start[block + 1]):
        i, k = part.entry_row[e], part.entry_column[e]
        z, dz, ddz = hat(q, frame, k, 1.0), hat(v, frame, k, 0.0), hat(acc, frame, k, 0.0)
        for j, factor in enumerate((z, dz, ddz)):
            work.products[j, i] += part.inertia[e] * factor
            work.products[3 + j, i] += part.gyroscopic[e] * factor
    for e in range(part.stiffened_start[block], part.stiffened_start[block + 1]):
        i, k = part.stiffened_row[e], part.stiffened_column[e]
        work.products[0, i] -= part.stiffening[e] * q[frame + 2 + k]
        work.products[1, i] -= part.stiffening[e] * v[frame + 2 + k]


@inlined
def add_block_residual(part, block, q, v, acc, g_x, g_y, work, inertial, applied):
    """Add one block's terms of the residual, for a body or for a design derivative of its invariants.

    g includes the load scale.
    """
    body = part.block_body[block]
    frame, n, m = part.frame[body], part.n_f[body], part.mass[block]
    omega, alpha = v[frame + 2], acc[frame + 2]
    x, y = acc[frame], acc[frame + 1]
    (nx, ny), (dx, dy), (ax, ay) = work.first
    inertial[frame] += m * x - ny * alpha + ax
    inertial[frame + 1] += m * y + nx * alpha + ay
    applied[frame] += -omega * omega * nx - 2 * omega * dy - m * g_x
    applied[frame + 1] += -omega * omega * ny + 2 * omega * dx - m * g_y
    spin, coupling, rate = 0 * x, 0 * x, 0 * x
    for i in range(1 + n):
        z = hat(q, frame, i, 1.0)
        spin += z * work.products[0, i]
        coupling += z * work.products[5, i]
        rate += z * work.products[1, i]
    inertial[frame + 2] += -ny * x + nx * y + spin * alpha + coupling
    applied[frame + 2] += 2 * omega * rate + ny * g_x - nx * g_y
    add_elastic_residual(part, block, q, v, acc, g_x, g_y, work, inertial, applied)


@inlined
def add_elastic_residual(part, block, q, v, acc, g_x, g_y, work, inertial, applied):
    """Add one block's terms of the elastic rows."""
    body = part.block_body[block]
    frame, n = part.frame[body], part.n_f[body]
    omega, alpha = v[frame + 2], acc[frame + 2]
    c, s = np.cos(q[frame + 2]), np.sin(q[frame + 2])
    for i in range(1, 1 + n):
        row = frame + 2 + i
        moment = part.moment[part.moment_start[block] + i]
        tx, ty = c * moment[0] - s * moment[1], s * moment[0] + c * moment[1]
        inertial[row] += tx * acc[frame] + ty * acc[frame + 1] - work.products[3, i] * alpha + work.products[2, i]
        applied[row] += -omega * omega * work.products[0, i] - 2 * omega * work.products[4, i] - tx * g_x - ty * g_y


@inlined
def floating_residual(part, q, v, acc, scale, work, inertial, applied):
    """Residual of all bodies with a moving frame."""
    g_x, g_y = scale * part.gravity[0], scale * part.gravity[1]
    for b in range(len(part.frame)):
        multiply_block(part, b, q, v, acc, work)
        add_block_residual(part, b, q, v, acc, g_x, g_y, work, inertial, applied)


@inlined
def floating_design(part, q, v, acc, scale, work, I_x, A_x):
    """Partial design derivatives of the residual: derivatives of the invariants, and of gravity."""
    g_x, g_y = scale * part.gravity[0], scale * part.gravity[1]
    for block in range(len(part.frame), len(part.block_body)):
        x = part.block_variable[block]
        multiply_block(part, block, q, v, acc, work)
        add_block_residual(part, block, q, v, acc, g_x, g_y, work, I_x[:, x], A_x[:, x])
    for b in range(len(part.frame)):
        frame, n = part.frame[b], part.n_f[b]
        c, s = np.cos(q[frame + 2]), np.sin(q[frame + 2])
        multiply_block(part, b, q, v, acc, work)
        nx, ny = work.first[0]
        for d in range(len(part.gravity_variable)):
            x, h_x, h_y = part.gravity_variable[d], scale * part.design_gravity[d, 0], scale * part.design_gravity[d, 1]
            A_x[frame, x] -= part.mass[b] * h_x
            A_x[frame + 1, x] -= part.mass[b] * h_y
            A_x[frame + 2, x] -= -ny * h_x + nx * h_y
            for i in range(1, 1 + n):
                moment = part.moment[part.moment_start[b] + i]
                tx, ty = c * moment[0] - s * moment[1], s * moment[0] + c * moment[1]
                A_x[frame + 2 + i, x] -= tx * h_x + ty * h_y


@inlined
def add_frame_jacobian(part, b, q, v, acc, g_x, g_y, work, I_acc, I_q, A_q, A_v):
    """Add the entries between the three frame coordinates."""
    frame, n, m = part.frame[b], part.n_f[b], part.mass[b]
    omega, alpha = v[frame + 2], acc[frame + 2]
    at = part.border[part.border_start[b] :]
    w = 3 + n
    (nx, ny), (dx, dy), (ax, ay) = work.first
    I_acc[at[0]] += m
    I_acc[at[w + 1]] += m
    for k in range(2):
        mixed = -ny if k == 0 else nx
        I_acc[at[k * w + 2]] += mixed
        I_acc[at[2 * w + k]] += mixed
    spin, rate = 0 * nx, 0 * nx
    for i in range(1 + n):
        spin += hat(q, frame, i, 1.0) * work.products[0, i]
        rate += hat(q, frame, i, 1.0) * work.products[1, i]
    I_acc[at[2 * w + 2]] += spin
    I_q[at[2]] += -nx * alpha - ay
    I_q[at[w + 2]] += -ny * alpha + ax
    I_q[at[2 * w + 2]] += -nx * acc[frame] - ny * acc[frame + 1]
    A_q[at[2]] += omega * omega * ny - 2 * omega * dx
    A_q[at[w + 2]] += -omega * omega * nx - 2 * omega * dy
    A_q[at[2 * w + 2]] += nx * g_x + ny * g_y
    A_v[at[2]] += -2 * omega * nx - 2 * dy
    A_v[at[w + 2]] += -2 * omega * ny + 2 * dx
    A_v[at[2 * w + 2]] += 2 * rate


@inlined
def add_border_jacobian(part, b, q, v, acc, g_x, g_y, work, I_acc, I_q, A_q, A_v):
    """Add the entries between frame and elastic coordinates."""
    frame, n = part.frame[b], part.n_f[b]
    omega, alpha = v[frame + 2], acc[frame + 2]
    x, y = acc[frame], acc[frame + 1]
    c, s = np.cos(q[frame + 2]), np.sin(q[frame + 2])
    at = part.border[part.border_start[b] :]
    w = 3 + n
    for i in range(1, 1 + n):
        moment = part.moment[part.moment_start[b] + i]
        tx, ty = c * moment[0] - s * moment[1], s * moment[0] + c * moment[1]
        Gz, Gdz, _, Hz, Hdz, Ha = work.products[:, i]
        x_row, y_row, turn_row = at[2 + i], at[w + 2 + i], at[2 * w + 2 + i]
        x_col, y_col, turn_col = at[3 * w + 3 * (i - 1)], at[3 * w + 3 * (i - 1) + 1], at[3 * w + 3 * (i - 1) + 2]
        for place in (x_row, x_col):
            I_acc[place] += tx
        for place in (y_row, y_col):
            I_acc[place] += ty
        for place in (turn_row, turn_col):
            I_acc[place] -= Hz
        I_q[x_row] -= ty * alpha
        I_q[y_row] += tx * alpha
        I_q[turn_row] += -ty * x + tx * y + 2 * Gz * alpha + Ha
        I_q[turn_col] += -ty * x + tx * y
        A_q[x_row] -= omega * omega * tx
        A_q[y_row] -= omega * omega * ty
        A_q[turn_row] += 2 * omega * Gdz + ty * g_x - tx * g_y
        A_q[turn_col] += ty * g_x - tx * g_y
        A_v[x_row] -= 2 * omega * ty
        A_v[y_row] += 2 * omega * tx
        A_v[turn_row] += 2 * omega * Gz
        A_v[turn_col] += -2 * omega * Gz - 2 * Hdz


@inlined
def add_elastic_jacobian(part, b, v, acc, I_acc, I_q, A_q, A_v):
    """Add the entries between elastic coordinates."""
    omega, alpha = v[part.frame[b] + 2], acc[part.frame[b] + 2]
    for e in range(part.entry_start[b], part.entry_start[b + 1]):
        if part.entry_row[e] > 0 and part.entry_column[e] > 0:
            at = part.entry_position[e]
            I_acc[at] += part.inertia[e]
            I_q[at] -= alpha * part.gyroscopic[e]
            A_q[at] -= omega * omega * part.inertia[e]
            A_v[at] -= 2 * omega * part.gyroscopic[e]
    for e in range(part.stiffened_start[b], part.stiffened_start[b + 1]):
        A_q[part.stiffened_position[e]] += omega * omega * part.stiffening[e]


@inlined
def floating_jacobian(part, q, v, acc, scale, work, I_acc, I_q, A_q, A_v):
    """Derivatives of the residual by q, v and a."""
    g_x, g_y = scale * part.gravity[0], scale * part.gravity[1]
    for b in range(len(part.frame)):
        multiply_block(part, b, q, v, acc, work)
        add_frame_jacobian(part, b, q, v, acc, g_x, g_y, work, I_acc, I_q, A_q, A_v)
        add_border_jacobian(part, b, q, v, acc, g_x, g_y, work, I_acc, I_q, A_q, A_v)
        add_elastic_jacobian(part, b, v, acc, I_acc, I_q, A_q, A_v)
