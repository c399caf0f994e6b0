"""Constant terms of the equations of motion: rigid bodies (frame at the centre of mass) and grounded flexible bodies.

With the constant force f, in the two groups of the residual:

    inertial: M a        applied: D v + K q - scale f,    scale = 1 but in a stepwise loaded static analysis

A thin body is up to 1e9 times stiffer in stretching than in bending, so that K q is a small difference of large products. Rounded like
any sum, it would move the state by 1e-8 of its bending, and gradients with it. So K is applied in its factors where these are known, see
`linear.linear_solver`, and of other bodies the stiffest entries, which make that round-off, are summed in twice the precision (Dekker
1971), the others as usual.

Bodies whose frame moves, in the plane and in space alike; which formulas run is known when they are compiled, as in `poses`.

Damping that follows the mass is a force -alpha rho v on every bit of a body, whose virtual work is -dq . alpha M(q) v with the mass matrix
M of the inertial terms. So it is these terms of invariants times alpha, at the velocities in the place of accelerations and in a body whose
velocities are zero; and it does not depend on the frame, as M(q) v does not.

`part` holds their invariants; `state` is that of the markers, whose frames in space are those of the bodies.
"""

from typing import NamedTuple

import numpy as np

from toolkit.components.bodies.kernels.planar_floating import floating_design, floating_jacobian, floating_residual
from toolkit.components.bodies.kernels.spatial_floating import spatial_design, spatial_linearized, spatial_residual
from toolkit.components.markers.poses import set_frames
from toolkit.foundation.kernel import copy, inlined, inner
from toolkit.linear.linear_solver import Factored, FactoredChanges, add_factored, add_factored_changes

HALVES = 134217729.0
"""2^27 + 1: splits a number into two of 26 bits, whose products are exact."""


EXACT, ROUGH, LEFT_OUT = range(3)
"""Ways of summing K q, in the caller's `Work.care`: as the head of this file says; as usual, where its round-off does not matter;
or no residual of the constant part, where derivatives alone are asked for."""


class Changes(NamedTuple):
    """Derivatives of the entries of a matrix by the design, apart from those that are zero; summed up run by run.

    A run is those of one row by one variable.
    """

    row: np.ndarray  # (n_runs,)
    variable: np.ndarray  # (n_runs,)
    start: np.ndarray  # (n_runs + 1,) into the next two
    column: np.ndarray  # (n_d,)
    value: np.ndarray  # (n_d,)


def together(one: Changes, other: Changes) -> Changes:
    """Changes of the sum of two matrices, from those of each."""
    later = other._replace(start=other.start[1:] + len(one.value))
    return Changes(*(np.concatenate(pair) for pair in zip(one, later, strict=True)))


class ConstantTerms(NamedTuple):
    """Entries of M, D, K (global rows and columns), the constant force f, and their design derivatives.

    Segments are the bodies' entries, one body after the other, row by row: those of a body that fills most of its matrices are all entries
    of a square, which need no list. Rows and columns are unsigned because numba then skips the test for indices counted from the end.
    """

    segment_start: np.ndarray  # (n_segments + 1,) into the entries
    segment_size: np.ndarray  # (n_segments,) rows of the square, 0 of a list
    segment_damped: np.ndarray  # (n_segments,) 1 if a square has mass or damping, which it mostly has not
    segment_loose: np.ndarray  # (n_segments,) 0 if nothing but mass is left of a list where stiffness is factored
    row: np.ndarray  # (n_entries,)
    column: np.ndarray
    position: np.ndarray  # where the entry is stored in the pattern
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    M: np.ndarray  # (n_pattern,) the same matrices on the whole pattern; (0,) of no entries
    D: np.ndarray
    K: np.ndarray
    soft: np.ndarray  # the stiffness where it is added as usual, otherwise 0
    stiff_row: np.ndarray  # rows with entries that are summed in twice the precision
    stiff_start: np.ndarray  # their first such entry, and the number of all such entries
    stiff_column: np.ndarray
    stiff_high: np.ndarray  # leading half of their digits
    stiff_low: np.ndarray  # the rest
    strains: Factored  # the stiffness of bodies that have it in its factors
    strained: np.ndarray  # (n_pattern,) and its entries; empty without such bodies
    loose: np.ndarray  # (n_pattern,) K without these
    force: np.ndarray  # (n_q,)
    design_mass: Changes
    design_damping: Changes
    design_stiffness: Changes
    design_loose: Changes  # the same without bodies that have factors
    design_strains: FactoredChanges
    force_row: np.ndarray  # (n_d,) which entry of f
    force_variable: np.ndarray
    design_force: np.ndarray


@inlined
def constant_residual(part, q, v, acc, scale, care, halves, inertial, applied):
    """Residual of the constant part, computed with as much `care`; `halves` (2, n) is scratch memory."""
    if care == LEFT_OUT:
        return
    stiffness = part.stiffness if care == ROUGH else part.soft
    for s in range(len(part.segment_size)):
        first, last, n = part.segment_start[s], part.segment_start[s + 1], part.segment_size[s]
        if n > 0:
            add_square_product(stiffness, first, n, part.row[first], q, applied)
            if part.segment_damped[s] == 1:
                add_square_product(part.damping, first, n, part.row[first], v, applied)
                add_square_product(part.mass, first, n, part.row[first], acc, inertial)
            continue
        e = first
        while e < last and care == EXACT and part.segment_loose[s] == 0:
            i = part.row[e]
            by_mass = inertial[i]
            while e < last and part.row[e] == i:
                by_mass += part.mass[e] * acc[part.column[e]]
                e += 1
            inertial[i] = by_mass
        while e < last:  # row by row, whose sums stay in registers
            i = part.row[e]
            by_mass, by_rest = inertial[i], applied[i]
            while e < last and part.row[e] == i:
                k = part.column[e]
                by_mass += part.mass[e] * acc[k]
                by_rest += part.damping[e] * v[k] + stiffness[e] * q[k]
                e += 1
            inertial[i], applied[i] = by_mass, by_rest
    if len(part.stiff_row) > 0 and care == EXACT:
        for k in range(len(q)):
            halves[0, k] = HALVES * q[k] - (HALVES * q[k] - q[k])
            halves[1, k] = q[k] - halves[0, k]
        for r in range(len(part.stiff_row)):
            applied[part.stiff_row[r]] += precise_sum(part, part.stiff_start[r], part.stiff_start[r + 1], q, halves)
    if care == EXACT:
        add_factored(part.strains, q, applied)
    for i in range(len(part.force)):
        applied[i] -= scale * part.force[i]


@inlined
def precise_sum(part, first, last, q, halves):
    """Sum of K_ik q_k over the stiff entries first ... last - 1, as if computed with 32 digits and rounded once."""
    total, rest = 0.0 * q[0], 0.0 * q[0]
    for e in range(first, last):
        high, k, before = part.stiff_high[e], part.stiff_column[e], total
        product = high * halves[0, k]
        total = before + product
        added = total - before
        rest += ((before - (total - added)) + (product - added)) + (high * halves[1, k] + part.stiff_low[e] * q[k])
    return total + rest


@inlined
def constant_jacobian(part, mixed, parts, apart, I_acc, I_q, A_q, A_v):
    """Jacobian of the constant part, which is the same in every step; everything else is added to it.

    `apart` is 1 if the factored stiffness is left out. Where the matrices are `mixed`, each is multiplied by its entry of `parts`
    in the one matrix that all four are.

    Where they are `mixed`, multiplied by its `parts` in the one matrix that all four are.
    """
    if mixed:
        by_a, _, by_q, by_v = parts
        M, D, K = part.M, part.D, part.K
        for e in range(len(I_acc) if len(M) == 0 else 0):
            I_acc[e] = 0
        for e in range(len(M)):
            I_acc[e] = by_a * M[e] + by_v * D[e] + by_q * K[e]
        return
    I_q[:] = 0
    if len(part.M) == 0:
        I_acc[:], A_q[:], A_v[:] = 0, 0, 0
    copy(part.M, I_acc)
    copy(part.loose if apart == 1 else part.K, A_q)
    copy(part.D, A_v)


@inlined
def add_square_product(values, first, n, at, x, target):
    """target += a square matrix, whose rows begin at `first`, times x, both from entry `at` on; four rows at a time."""
    source, i = x[at : at + n], 0
    while i + 4 <= n:
        row = first + i * n
        a, b, c, d = values[row : row + n], values[row + n :], values[row + 2 * n :], values[row + 3 * n :]
        s_a, s_b, s_c, s_d = target[at + i], target[at + i + 1], target[at + i + 2], target[at + i + 3]
        for j in range(n):
            s_a += a[j] * source[j]
            s_b += b[j] * source[j]
            s_c += c[j] * source[j]
            s_d += d[j] * source[j]
        target[at + i], target[at + i + 1], target[at + i + 2], target[at + i + 3] = s_a, s_b, s_c, s_d
        i += 4
    while i < n:
        row, total = values[first + i * n : first + i * n + n], target[at + i]
        for j in range(n):
            total += row[j] * source[j]
        target[at + i] = total
        i += 1


@inlined
def constant_design(part, q, v, acc, scale, I_x, A_x):
    """Partial design derivatives of the residual of the constant part."""
    add_changes(part.design_mass, acc, I_x)
    add_changes(part.design_damping, v, A_x)
    add_changes(part.design_loose, q, A_x)
    add_factored_changes(part.strains, part.design_strains, q, A_x)
    for d in range(len(part.force_row)):
        A_x[part.force_row[d], part.force_variable[d]] -= scale * part.design_force[d]


@inner
def add_changes(changes, vector, out):
    """out (n, n_x) += the change of a matrix by every variable, times a vector (n,)."""
    row, variable, start, column, value = changes.row, changes.variable, changes.start, changes.column, changes.value
    for run in range(len(row)):
        total = 0 * vector[0]
        for d in range(start[run], start[run + 1]):
            total += value[d] * vector[column[d]]
        out[row[run], variable[run]] += total


@inlined
def moving_residual(plane, frames, part, state, q, v, acc, scale, work, inertial, applied):
    """Residual of all bodies whose frame moves."""
    if plane is not None:
        floating_residual(part, q, v, acc, scale, work, inertial, applied)
    if frames is not None:
        spatial_residual(part, state.frames, q, v, acc, scale, work, inertial, applied)


@inlined
def moving_linearized(plane, frames, part, state, q, v, acc, scale, work, inertial, applied, I_acc, I_q, A_q, A_v):
    """The residual and its derivatives by q, v and a."""
    if plane is not None:
        floating_residual(part, q, v, acc, scale, work, inertial, applied)
        floating_jacobian(part, q, v, acc, scale, work, I_acc, I_q, A_q, A_v)
    if frames is not None:
        spatial_linearized(part, frames, state.frames, q, v, acc, scale, work, inertial, applied, I_acc, I_q, A_q, A_v)


@inlined
def moving_design(plane, frames, part, state, q, v, acc, scale, work, I_x, A_x):
    """Partial design derivatives of the residual."""
    if plane is not None:
        floating_design(part, q, v, acc, scale, work, I_x, A_x)
    if frames is not None:
        spatial_design(part, state.frames, q, v, acc, scale, work, I_x, A_x)


@inner
def add_drag(plane, frames, part, state, q, v, rest, linearize, parts, mixed, work, applied, A_q, A_v):
    """applied += alpha M(q) v, and if `linearize` its derivatives; leaves the frames at other rates. `rest` (n,) is zero."""
    set_frames(frames, state, q, rest, v)
    if linearize:
        if frames is not None:  # what M v is multiplied by in the matrix of a step, where all is added to that
            work.mixed[0] = 1 if mixed else 0
            work.mixed[1], work.mixed[2], work.mixed[3], work.mixed[4] = parts[3], parts[2], parts[2], parts[3]
        moving_linearized(plane, frames, part, state, q, rest, v, 0.0, work, applied, applied, A_v, A_q, A_q, A_v)
    else:
        moving_residual(plane, frames, part, state, q, rest, v, 0.0, work, applied, applied)


@inner
def add_drag_design(plane, frames, part, state, q, v, rest, work, A_x):
    """Add the partial design derivatives of the mass-proportional damping force alpha M(q) v to `A_x`."""
    set_frames(frames, state, q, rest, v)
    moving_design(plane, frames, part, state, q, rest, v, 0.0, work, A_x, A_x)
