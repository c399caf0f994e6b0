"""All loads in the compiled loop: chain rule from a force law on two poses to the equations, the same for every load.

A load is f(z, w): what is conjugate to the poses of two markers, z = (pose a, pose b, parameters, value of its time curve), w = z' of the
poses. A pose in the plane is (x, y, angle), in space four vectors, the position and three axes. Its kind supplies f, f_z and f_w. With
y' = B v it enters the applied group as - B^T f.

A load may have a state x of its own, such as an integral, behind the rates in w; then f holds x' in its last place. It is a coordinate
without mass, whose equation in the applied group is x' - f_last(z, w) = 0.
"""

from typing import NamedTuple

import numba
import numpy as np

from toolkit.components.markers.poses import add_pose_force, add_pose_force_design, add_pose_stiffness
from toolkit.foundation.kernel import inlined, inner

ARGUMENTS, CURVE = 13, 12
"""Most arguments z in the plane: two poses, six parameters, and the value of the time curve, which is the last one."""
SPATIAL_ARGUMENTS, SPATIAL_CURVE = 37, 36
"""Most arguments z in space: two poses of twelve numbers, twelve parameters, and the value of the time curve, which is the last
one."""

_f8 = numba.float64
SIGNATURE = numba.void(_f8[::1], _f8[::1], _f8[::1], _f8[:, ::1], _f8[:, ::1])
"""f(z, w, force, force_z, force_w); the last three are zero on entry and are filled. Behind the poses w and f have a place for a state."""


class Loads(NamedTuple):
    """Arrays of the loads, which never change."""

    family: np.ndarray  # (n_l,)
    marker: np.ndarray  # (n_l, 2)
    parameter: np.ndarray  # (n_l, ARGUMENTS - 7)
    curve: np.ndarray  # (n_l,) time curve, or -1 for the constant 1
    scaled: np.ndarray  # (n_l,) 1 if its curve grows with the loads, 0 if it leads as that of a driver does
    state: np.ndarray  # (n_l,) coordinate that is its state, or -1
    designed: np.ndarray  # (n,) 1 if any design variable matters to it
    design_start: np.ndarray  # (n_l + 1,) into the next three
    design_variable: np.ndarray
    design_parameter: np.ndarray
    design_value: np.ndarray
    position_start: np.ndarray  # (n_l,) into the next
    position: np.ndarray  # where the local entries coordinates x coordinates are stored


class LoadWork(NamedTuple):
    """Scratch memory for one load."""

    z: np.ndarray
    w: np.ndarray
    force: np.ndarray
    force_z: np.ndarray
    force_w: np.ndarray
    dforce: np.ndarray
    rateforce: np.ndarray
    changes: np.ndarray  # (n,) ints, 1 where an entry of f depends on the poses or their rates
    by_q: np.ndarray  # (n, most columns of a load) derivatives of f by the coordinates
    by_v: np.ndarray  # and by their rates


def load_work(loads: Loads, start: np.ndarray, pose: int, dtype: type) -> LoadWork:
    """Scratch memory for any load; `start` is that of the markers' columns, and a pose has so many entries."""
    z, w = (ARGUMENTS, 7) if pose == 3 else (SPATIAL_ARGUMENTS, 25)
    columns = int(max(np.diff(start)[loads.marker].sum(axis=1), default=0))
    return LoadWork(
        z=np.zeros(z, dtype),
        w=np.zeros(w, dtype),
        force=np.zeros(w, dtype),
        force_z=np.zeros((w, z), dtype),
        force_w=np.zeros((w, w), dtype),
        dforce=np.zeros(w, dtype),
        rateforce=np.zeros(w, dtype),
        changes=np.zeros(w, np.int64),
        by_q=np.zeros((w, columns), dtype),
        by_v=np.zeros((w, columns), dtype),
    )


@inlined
def evaluate_load(functions, loads, k, markers, state, q, curves, scale, work):
    """Evaluate the force law at the poses and rates of the two markers, and at its own state."""
    size, curve = len(markers.pose), len(work.z) - 1
    for side in range(2):
        m = loads.marker[k, side]
        for i in range(len(markers.pose)):
            work.z[size * side + i] = state.y[m, i]
            work.w[size * side + i] = state.rate[m, i]
    for i in range(curve - 2 * size):
        work.z[2 * size + i] = loads.parameter[k, i]
    work.w[2 * size] = q[loads.state[k]] if loads.state[k] >= 0 else 0 * q[0]
    work.z[curve] = curve_scale(loads, k, scale)
    if loads.curve[k] >= 0:
        work.z[curve] *= curves[loads.curve[k], 0]
    work.force[:] = 0
    work.force_z[:] = 0
    work.force_w[:] = 0
    functions[loads.family[k]](work.z, work.w, work.force, work.force_z, work.force_w)


@inlined
def curve_scale(loads, k, scale):
    """Factor of the value of a load's time curve: the load scale, or 1."""
    return scale if loads.scaled[k] else 1.0


@inlined
def load_residual(loads, k, markers, state, v, work, applied):
    """Add - B^T f to the residual, and x' - f_last in the row of the load's own state x."""
    add_both(loads, k, markers, state, work.force, applied)
    if loads.state[k] >= 0:
        applied[loads.state[k]] += v[loads.state[k]]


@inlined
def direction_force(markers, work, first, y, rate):
    """Derivative of f in a direction of one pose: f_z y + f_w rate."""
    for i in range(2 * len(markers.pose)):
        work.dforce[i] = 0
        for c in range(len(markers.pose)):
            work.dforce[i] += work.force_z[i, first + c] * y[c] + work.force_w[i, first + c] * rate[c]


@inlined
def direction_of_state(markers, work, first, y, rate):
    """Derivative of the last place of f, that of the load's own state, in a direction; and the product of f_w with y there."""
    last = 2 * len(markers.pose)
    work.dforce[last], work.rateforce[last] = 0, 0
    for c in range(len(markers.pose)):
        work.dforce[last] += work.force_z[last, first + c] * y[c] + work.force_w[last, first + c] * rate[c]
        work.rateforce[last] += work.force_w[last, first + c] * y[c]


@inlined
def load_jacobian(loads, k, markers, state, work, parts, A_q, A_v):
    """Derivatives of - B^T f by q and v, scattered into the pattern, each group multiplied by its part."""
    by_s, by_v = parts[2], parts[3]
    a, b = loads.marker[k, 0], loads.marker[k, 1]
    n_a = markers.start[a + 1] - markers.start[a]
    n_both = n_a + markers.start[b + 1] - markers.start[b]
    n = n_both + 1 if loads.state[k] >= 0 else n_both
    position, size = loads.position[loads.position_start[k] :], len(markers.pose)
    if find_changes(2 * size, work):
        for side in range(2):
            force_columns(loads, k, markers, state, side, side * n_a, work, by_s, by_v)
        for side in range(2):
            for other in range(2):
                subtract_block(loads, k, markers, state, side, other, n_a, n, position, work, A_q, A_v)
    for side in range(2):
        force = work.force[size * side : size * side + size]
        add_pose_stiffness(
            markers.plane, markers.frames, markers, state, loads.marker[k, side], force, -by_s, position, n, side * n_a, A_q
        )
    if loads.state[k] >= 0:
        state_jacobian(loads, k, markers, state, n_a, n, position, work, by_s, by_v, A_q, A_v)


@inlined
def find_changes(count, work):
    """Find which entries of f depend on the poses; returns whether any does.

    Those of a constant force do not, nor does what acts on no axis.
    """
    found = False
    for i in range(count):
        work.changes[i] = 0
        for c in range(count):
            if work.force_z[i, c] != 0 or work.force_w[i, c] != 0:
                work.changes[i], found = 1, True
    return found


@inlined
def force_columns(loads, k, markers, state, side, first, work, by_s, by_v):
    """Derivatives of f by the coordinates of one marker, f_z B + f_w B_v, and by their rates, f_w B, from number `first` on; multiplied."""
    m, size = loads.marker[k, side], len(markers.pose)
    for i in range(2 * size):
        if work.changes[i]:
            by_z, by_w = work.force_z[i, size * side :], work.force_w[i, size * side :]
            for column in range(markers.start[m], markers.start[m + 1]):
                moved, turned = 0 * by_z[0], 0 * by_z[0]
                for c in range(size):
                    moved += by_z[c] * state.B[column, c] + by_w[c] * state.B_v[column, c]
                    turned += by_w[c] * state.B[column, c]
                work.by_q[i, first + column - markers.start[m]] = by_s * moved
                work.by_v[i, first + column - markers.start[m]] = by_v * turned


@inner
def subtract_block(loads, k, markers, state, side, other, n_a, n, position, work, A_q, A_v):
    """Subtract B^T times derivatives of f, rows of one marker and columns of another, from A_q and A_v."""
    m, o, size = loads.marker[k, side], loads.marker[k, other], len(markers.pose)
    count, first = markers.start[o + 1] - markers.start[o], other * n_a
    together = count > 0 and follow_each_other(markers.coordinate[markers.start[o] : markers.start[o + 1]])
    for row in range(markers.start[m], markers.start[m + 1]):
        at = (row - markers.start[m] + side * n_a) * n + first
        for c in range(size):
            factor, i = state.B[row, c], size * side + c
            if work.changes[i] and factor != 0:
                place, by_q, by_v = position[at : at + count], work.by_q[i, first:], work.by_v[i, first:]
                if together:
                    to_q, to_v = A_q[place[0] : place[0] + count], A_v[place[0] : place[0] + count]
                    for j in range(count):
                        to_q[j] -= factor * by_q[j]
                        to_v[j] -= factor * by_v[j]
                else:
                    for j in range(count):
                        A_q[place[j]] -= factor * by_q[j]
                        A_v[place[j]] -= factor * by_v[j]


@inner
def follow_each_other(numbers):
    """Whether each number is the next after the one before it: then entries of a row in such columns stand next to each other."""
    gaps = 0
    for i in range(1, len(numbers)):
        gaps += numbers[i] != numbers[i - 1] + 1
    return gaps == 0


@inner
def state_jacobian(loads, k, markers, state, n_a, n, position, work, by_s, by_v, A_q, A_v):
    """Add row and column of the state of a load to the Jacobian."""
    size, last = len(markers.pose), n - 1
    for side in range(2):
        m = loads.marker[k, side]
        for column in range(markers.start[m], markers.start[m + 1]):
            local = column - markers.start[m] + side * n_a
            direction_of_state(markers, work, size * side, state.B[column], state.B_v[column])
            A_q[position[last * n + local]] -= by_s * work.dforce[2 * size]
            A_v[position[last * n + local]] -= by_v * work.rateforce[2 * size]
            for c in range(size):
                A_q[position[local * n + last]] -= by_s * state.B[column, c] * work.force_w[size * side + c, 2 * size]
    A_q[position[n * n - 1]] -= by_s * work.force_w[2 * size, 2 * size]
    A_v[position[n * n - 1]] += by_v


@inlined
def load_design(loads, k, markers, state, curve_variable, curve_index, curve_x, scale, work, A_x):
    """Partial derivatives of - B^T f by the design: markers, parameters, time curve."""
    size, curve = len(markers.pose), len(work.z) - 1
    for side in range(2):
        m = loads.marker[k, side]
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            direction_force(markers, work, size * side, state.y_x[d], state.rate_x[d])
            if loads.state[k] >= 0:
                direction_of_state(markers, work, size * side, state.y_x[d], state.rate_x[d])
            add_both(loads, k, markers, state, work.dforce, A_x[:, markers.design_variable[d]])
            add_pose_force_design(
                markers.plane, markers.frames, markers, state, m, d, work.force[size * side : size * side + size], -1.0, A_x
            )
    for d in range(loads.design_start[k], loads.design_start[k + 1]):
        for i in range(2 * size + 1):
            work.dforce[i] = work.force_z[i, 2 * size + loads.design_parameter[d]] * loads.design_value[d]
        add_both(loads, k, markers, state, work.dforce, A_x[:, loads.design_variable[d]])
    for d in range(len(curve_index)):
        if curve_index[d] == loads.curve[k]:
            for i in range(2 * size + 1):
                work.dforce[i] = work.force_z[i, curve] * curve_scale(loads, k, scale) * curve_x[d, 0]
            add_both(loads, k, markers, state, work.dforce, A_x[:, curve_variable[d]])


@inlined
def add_both(loads, k, markers, state, force, residual):
    """Subtract B^T force from the residual, on both markers, and the entry of the load's own state."""
    size = len(markers.pose)
    add_pose_force(markers.plane, markers.frames, markers, state, loads.marker[k, 0], force[:size], -1.0, residual)
    add_pose_force(markers.plane, markers.frames, markers, state, loads.marker[k, 1], force[size : 2 * size], -1.0, residual)
    if loads.state[k] >= 0:
        residual[loads.state[k]] -= force[2 * size]
