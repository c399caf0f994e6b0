"""All loads in the compiled loop: chain rule from a force law on two poses to the equations, the same for every load.

A load is f(z, w): forces and torques on two markers, z = (pose a, pose b, parameters, value of its time curve), w = z' of the poses.
Its kind supplies f, f_z and f_w. With y' = B v it enters the applied group as - B^T f.
"""

from typing import NamedTuple

import numba
import numpy as np

from toolkit.bodies.marker_forces import add_force, add_force_design, add_geometric_stiffness
from toolkit.kernel import inner

ARGUMENTS, CURVE = 12, 11
"""Most arguments z: two poses, five parameters, and the value of the time curve, which is the last one."""

_f8 = numba.float64
SIGNATURE = numba.void(_f8[::1], _f8[::1], _f8[::1], _f8[:, ::1], _f8[:, ::1])
"""f(z, w, force, force_z, force_w); the last three are zero on entry and are filled."""


class Loads(NamedTuple):
    """What never changes."""

    family: np.ndarray  # (n_l,)
    marker: np.ndarray  # (n_l, 2)
    parameter: np.ndarray  # (n_l, ARGUMENTS - 7)
    curve: np.ndarray  # (n_l,) time curve, or -1 for the constant 1
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


def load_work(dtype: type) -> LoadWork:
    """Memory for any load."""
    return LoadWork(*(np.zeros(s, dtype) for s in (ARGUMENTS, 6, 6, (6, ARGUMENTS), (6, 6), 6, 6)))


@inner
def evaluate_load(functions, loads, k, state, curves, scale, work):
    """The force law at the poses and rates of the two markers."""
    for side in range(2):
        m = loads.marker[k, side]
        for i in range(3):
            work.z[3 * side + i] = state.y[m, i]
            work.w[3 * side + i] = state.rate[m, i]
    for i in range(CURVE - 6):
        work.z[6 + i] = loads.parameter[k, i]
    work.z[CURVE] = scale
    if loads.curve[k] >= 0:
        work.z[CURVE] *= curves[loads.curve[k], 0]
    work.force[:] = 0
    work.force_z[:] = 0
    work.force_w[:] = 0
    functions[loads.family[k]](work.z, work.w, work.force, work.force_z, work.force_w)


@inner
def load_residual(loads, k, markers, state, work, applied):
    """- B^T f."""
    for side in range(2):
        add_force(markers, state, loads.marker[k, side], work.force[3 * side : 3 * side + 3], -1.0, applied)


@inner
def direction_force(work, first, y, rate):
    """Derivative of f in a direction of one pose: f_z y + f_w rate."""
    for i in range(6):
        work.dforce[i] = 0
        for c in range(3):
            work.dforce[i] += work.force_z[i, first + c] * y[c] + work.force_w[i, first + c] * rate[c]


@inner
def load_jacobian(loads, k, markers, state, work, A_q, A_v):
    """Derivatives of - B^T f by q and v, scattered into the pattern."""
    a, b = loads.marker[k, 0], loads.marker[k, 1]
    n_a = markers.start[a + 1] - markers.start[a]
    n = n_a + markers.start[b + 1] - markers.start[b]
    position = loads.position[loads.position_start[k] :]
    for side in range(2):
        m = loads.marker[k, side]
        for column in range(markers.start[m], markers.start[m + 1]):
            local = column - markers.start[m] + side * n_a
            direction_force(work, 3 * side, state.B[column], state.B_v[column])
            for i in range(6):
                work.rateforce[i] = 0
                for c in range(3):
                    work.rateforce[i] += work.force_w[i, 3 * side + c] * state.B[column, c]
            load_column(loads, k, markers, state, local, n, n_a, position, work, A_q, A_v)
        add_geometric_stiffness(markers, state, m, work.force[3 * side : 3 * side + 3], -1.0, position, n, side * n_a, A_q)


@inner
def load_column(loads, k, markers, state, local, n, n_a, position, work, A_q, A_v):
    """One column of - B^T (f_z B + f_w B_v) and of - B^T f_w B."""
    for side in range(2):
        m = loads.marker[k, side]
        for row in range(markers.start[m], markers.start[m + 1]):
            at = position[(row - markers.start[m] + side * n_a) * n + local]
            for c in range(3):
                A_q[at] -= state.B[row, c] * work.dforce[3 * side + c]
                A_v[at] -= state.B[row, c] * work.rateforce[3 * side + c]


@inner
def load_design(loads, k, markers, state, q, curve_variable, curve_index, curve_x, scale, work, A_x):
    """Partial derivatives of - B^T f by the design: markers, parameters, time curve."""
    for side in range(2):
        m = loads.marker[k, side]
        frame = markers.frame[m]
        c, s = (np.cos(q[frame + 2]), np.sin(q[frame + 2])) if frame >= 0 else (1 + 0 * q[0], 0 * q[0])
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            direction_force(work, 3 * side, state.y_x[d], state.rate_x[d])
            add_both(loads, k, markers, state, work.dforce, A_x[:, markers.design_variable[d]])
            add_force_design(markers, state, m, d, work.force[3 * side : 3 * side + 3], -1.0, c, s, A_x)
    for d in range(loads.design_start[k], loads.design_start[k + 1]):
        for i in range(6):
            work.dforce[i] = work.force_z[i, 6 + loads.design_parameter[d]] * loads.design_value[d]
        add_both(loads, k, markers, state, work.dforce, A_x[:, loads.design_variable[d]])
    for d in range(len(curve_index)):
        if curve_index[d] == loads.curve[k]:
            for i in range(6):
                work.dforce[i] = work.force_z[i, CURVE] * scale * curve_x[d, 0]
            add_both(loads, k, markers, state, work.dforce, A_x[:, curve_variable[d]])


@inner
def add_both(loads, k, markers, state, force, residual):
    """residual -= B^T force, on both markers."""
    for side in range(2):
        add_force(markers, state, loads.marker[k, side], force[3 * side : 3 * side + 3], -1.0, residual)
