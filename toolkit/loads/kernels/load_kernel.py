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

from toolkit.foundation.kernel import inlined
from toolkit.markers.poses import add_pose_force, add_pose_force_design, add_pose_stiffness

ARGUMENTS, CURVE = 13, 12
"""Most arguments z in the plane: two poses, six parameters, and the value of the time curve, which is the last one."""
SPATIAL_ARGUMENTS, SPATIAL_CURVE = 37, 36
"""The same in space: two poses of twelve numbers, twelve parameters, and the value of the time curve."""

_f8 = numba.float64
SIGNATURE = numba.void(_f8[::1], _f8[::1], _f8[::1], _f8[:, ::1], _f8[:, ::1])
"""f(z, w, force, force_z, force_w); the last three are zero on entry and are filled. Behind the poses w and f have a place for a state."""


class Loads(NamedTuple):
    """What never changes."""

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


def load_work(pose: int, dtype: type) -> LoadWork:
    """Memory for any load, for a number of entries of a pose."""
    z, w = (ARGUMENTS, 7) if pose == 3 else (SPATIAL_ARGUMENTS, 25)
    return LoadWork(*(np.zeros(s, dtype) for s in (z, w, w, (w, z), (w, w), w, w)))


@inlined
def evaluate_load(functions, loads, k, markers, state, q, curves, scale, work):
    """The force law at the poses and rates of the two markers, and at its own state."""
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
    """What the value of its time curve is multiplied by."""
    return scale if loads.scaled[k] else 1.0


@inlined
def load_residual(loads, k, markers, state, v, work, applied):
    """- B^T f, and of its own state x' - f_last."""
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
    """The same of the last place, that of the load's own state, and the product of f_w with y there."""
    last = 2 * len(markers.pose)
    work.dforce[last], work.rateforce[last] = 0, 0
    for c in range(len(markers.pose)):
        work.dforce[last] += work.force_z[last, first + c] * y[c] + work.force_w[last, first + c] * rate[c]
        work.rateforce[last] += work.force_w[last, first + c] * y[c]


@inlined
def load_jacobian(loads, k, markers, state, work, A_q, A_v):
    """Derivatives of - B^T f by q and v, scattered into the pattern."""
    a, b = loads.marker[k, 0], loads.marker[k, 1]
    n_a = markers.start[a + 1] - markers.start[a]
    n_both = n_a + markers.start[b + 1] - markers.start[b]
    n = n_both + 1 if loads.state[k] >= 0 else n_both
    position, size = loads.position[loads.position_start[k] :], len(markers.pose)
    for side in range(2):
        m = loads.marker[k, side]
        for column in range(markers.start[m], markers.start[m + 1]):
            local = column - markers.start[m] + side * n_a
            direction_force(markers, work, size * side, state.B[column], state.B_v[column])
            if loads.state[k] >= 0:
                direction_of_state(markers, work, size * side, state.B[column], state.B_v[column])
            for i in range(2 * size):
                work.rateforce[i] = 0
                for c in range(len(markers.pose)):
                    work.rateforce[i] += work.force_w[i, size * side + c] * state.B[column, c]
            load_column(loads, k, markers, state, local, n, n_a, position, work, A_q, A_v)
        force = work.force[size * side : size * side + size]
        add_pose_stiffness(markers.plane, markers.frames, markers, state, m, force, -1.0, position, n, side * n_a, A_q)
    if loads.state[k] >= 0:
        for i in range(2 * size + 1):
            work.dforce[i], work.rateforce[i] = work.force_w[i, 2 * size], 0
        load_column(loads, k, markers, state, n_both, n, n_a, position, work, A_q, A_v)
        A_v[position[n * n - 1]] += 1


@inlined
def load_column(loads, k, markers, state, local, n, n_a, position, work, A_q, A_v):
    """One column of - B^T (f_z B + f_w B_v) and of - B^T f_w B, and of the row of its own state."""
    if loads.state[k] >= 0:
        A_q[position[(n - 1) * n + local]] -= work.dforce[2 * len(markers.pose)]
        A_v[position[(n - 1) * n + local]] -= work.rateforce[2 * len(markers.pose)]
    for side in range(2):
        m = loads.marker[k, side]
        for row in range(markers.start[m], markers.start[m + 1]):
            at = position[(row - markers.start[m] + side * n_a) * n + local]
            for c in range(len(markers.pose)):
                A_q[at] -= state.B[row, c] * work.dforce[len(markers.pose) * side + c]
                A_v[at] -= state.B[row, c] * work.rateforce[len(markers.pose) * side + c]


@inlined
def load_design(loads, k, markers, state, q, curve_variable, curve_index, curve_x, scale, work, A_x):
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
                markers.plane, markers.frames, markers, state, m, d, work.force[size * side : size * side + size], -1.0, q, A_x
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
    """residual -= B^T force, on both markers, and on its own state."""
    size = len(markers.pose)
    add_pose_force(markers.plane, markers.frames, markers, state, loads.marker[k, 0], force[:size], -1.0, residual)
    add_pose_force(markers.plane, markers.frames, markers, state, loads.marker[k, 1], force[size : 2 * size], -1.0, residual)
    if loads.state[k] >= 0:
        residual[loads.state[k]] -= force[2 * size]
