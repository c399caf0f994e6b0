"""Bodies with a moving frame in the compiled loop: derivatives of the residual of `floating_kernel` by q, v and a."""

import numpy as np

from toolkit.bodies.kernels.planar.floating_kernel import hat, multiply_block
from toolkit.foundation.kernel import inlined


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
