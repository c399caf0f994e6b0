"""Pressures on surfaces of flexible bodies in the compiled loop; they follow the frame of their body.

With f and L of `SurfaceLoad`, times the pressure, s the value of the time curve, L(z^)_ab = L[a, b] z^ and <P, S> = sum_ab P_ab S_ab,
the virtual power s int p (-n) . A^T (dr + dA u + A Psi dc) dA gives in the applied group

    t: - s A f        k: - s <A_k, A L(z^)>        f: - s sum_a L[a, a]_f
"""

from typing import NamedTuple

import numpy as np

from toolkit.foundation.kernel import inlined, inner
from toolkit.foundation.kinematics.orientation import second_products


class Pressures(NamedTuple):
    """Arrays of the pressures, which never change.

    Blocks 0 ... n - 1 are the pressures; every further block is a derivative by a design variable.
    """

    block_load: np.ndarray  # (n_blocks,)
    block_variable: np.ndarray  # (n_blocks,) -1 for the pressures themselves
    curve: np.ndarray  # (n,) time curve, or -1 for the constant 1
    frame: np.ndarray  # (n,) number of the body's frame; the last for bodies that do not turn
    first: np.ndarray  # (n,) global number of the body's first coordinate
    moves: np.ndarray  # (n,) 3 if its body has r, otherwise 0
    turns: np.ndarray  # (n,) how many orientation coordinates it has
    n_f: np.ndarray  # (n,)
    force: np.ndarray  # (n_blocks, 3) f
    start: np.ndarray  # (n_blocks,) into the next
    moment: np.ndarray  # (..., 9) L, b running fastest; rows count z^
    position_start: np.ndarray  # (n,) into the next
    position: np.ndarray  # where the frame's rows are stored: frame x (frame + n_f)


@inner
def moment_of(part, block, q, out):
    """Matrix L(z^) of one block, (3, 3)."""
    k = part.block_load[block]
    elastic, row = part.first[k] + part.moves[k] + part.turns[k], part.start[block]
    for i in range(9):
        out[i // 3, i % 3] = part.moment[row, i] + 0 * q[0]
        for j in range(part.n_f[k]):
            out[i // 3, i % 3] += part.moment[row + 1 + j, i] * q[elastic + j]


@inner
def moment_product(A_k, A, L):
    """Sum <A_k, A L> of products of all nine entries."""
    total = 0 * L[0, 0]
    for i in range(3):
        for b in range(3):
            total += A_k[i, b] * (A[i, 0] * L[0, b] + A[i, 1] * L[1, b] + A[i, 2] * L[2, b])
    return total


@inner
def add_block(part, frames, block, factor, L, q, residual):
    """Subtract factor times the generalised force of one block from the residual."""
    k = part.block_load[block]
    f, first, turn = part.frame[k], part.first[k], part.first[k] + part.moves[k]
    for i in range(part.moves[k]):
        for j in range(3):
            residual[first + i] -= factor * frames.A[f, i, j] * part.force[block, j]
    if part.turns[k] > 0:
        moment_of(part, block, q, L)
    for i in range(part.turns[k]):
        residual[turn + i] -= factor * moment_product(frames.A_k[f, i], frames.A[f], L)
    for j in range(part.n_f[k]):
        row = part.moment[part.start[block] + 1 + j]
        residual[turn + part.turns[k] + j] -= factor * (row[0] + row[4] + row[8])


@inlined
def add_pressures(part, turning, state, q, curves, scale, linearize, L, by_s, applied, A_q):
    """Add the residual of all pressures, and if `linearize` its derivative by q, times `by_s`; nothing in the plane.

    L is (3, 3).
    """
    if part is not None:
        for k in range(len(part.curve)):
            factor = scale * curves[part.curve[k], 0] if part.curve[k] >= 0 else scale
            add_block(part, state.frames, k, factor, L, q, applied)
            if linearize and part.turns[k] > 0:
                add_turning_rows(part, turning, state, k, by_s * factor, L, A_q)
                add_elastic_rows(part, state.frames, k, by_s * factor, A_q)


@inner
def add_turning_rows(part, turning, state, k, factor, L, A_q):
    """Add derivatives by the orientation of the rows of r and of the orientation; L holds L(z^)."""
    frames, f, n_r, n_b = state.frames, part.frame[k], part.moves[k], part.turns[k]
    width = n_r + n_b + part.n_f[k]
    at, A, product = part.position[part.position_start[k] :], frames.A[f], frames.scratch
    for i in range(3):
        for b in range(3):
            product[i, b] = A[i, 0] * L[0, b] + A[i, 1] * L[1, b] + A[i, 2] * L[2, b]
    second_products(turning, frames, f, product, state.square)
    for i in range(n_b):
        for c in range(n_b):
            entry = moment_product(frames.A_k[f, i], frames.A_k[f, c], L) + state.square[i, c]
            A_q[at[(n_r + i) * width + n_r + c]] -= factor * entry
        for row in range(n_r):
            entry = 0 * L[0, 0]
            for j in range(3):
                entry += frames.A_k[f, i, row, j] * part.force[k, j]
            A_q[at[row * width + n_r + i]] -= factor * entry


@inner
def add_elastic_rows(part, frames, k, factor, A_q):
    """Add derivatives of the rows of the orientation by the elastic coordinates."""
    f, n_r, n_b, moment = part.frame[k], part.moves[k], part.turns[k], frames.scratch
    width = n_r + n_b + part.n_f[k]
    at = part.position[part.position_start[k] :]
    for j in range(part.n_f[k]):
        for b in range(9):
            moment[b // 3, b % 3] = part.moment[part.start[k] + 1 + j, b]
        for i in range(n_b):
            entry = moment_product(frames.A_k[f, i], frames.A[f], moment)
            A_q[at[(n_r + i) * width + n_r + n_b + j]] -= factor * entry


@inlined
def add_pressure_designs(part, state, q, curves, curves_x, curve_variable, curve_index, scale, L, A_x):
    """Add partial derivatives by the design: pressures and what the surfaces depend on, time curves."""
    if part is not None:
        for block in range(len(part.curve), len(part.block_load)):
            k = part.block_load[block]
            factor = scale * curves[part.curve[k], 0] if part.curve[k] >= 0 else scale
            add_block(part, state.frames, block, factor, L, q, A_x[:, part.block_variable[block]])
        for k in range(len(part.curve)):
            for d in range(len(curve_index)):
                if curve_index[d] == part.curve[k]:
                    add_block(part, state.frames, k, scale * curves_x[d, 0], L, q, A_x[:, curve_variable[d]])
